// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/population.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <cstdio>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

std::vector<PopulationMember> members_at(const Eigen::VectorXd& estimates, double deviation) {
  std::vector<PopulationMember> members;
  for (const double estimate : estimates) members.push_back({estimate, deviation});
  return members;
}

TEST(Population, OfExactEstimatesIsThatOfStudent) {
  const Eigen::VectorXd estimates{{103.0, 98.0, 101.0, 99.5}};
  const double mean = estimates.mean(), deviation = std::sqrt((estimates.array() - mean).square().sum() / 3.0);
  const auto found = population_of(members_at(estimates, 1e-6));
  const double t = student_t_quantile(0.975, 3.0);
  EXPECT_NEAR(found.mean.median, mean, 1e-6);
  EXPECT_NEAR(found.mean.interval[1], mean + t * deviation / 2.0, 2e-3 * deviation);  // n = 4: sd / sqrt(4)
  EXPECT_NEAR(found.next.interval[0], mean - t * deviation * std::sqrt(1.25), 2e-3 * deviation);
  EXPECT_NEAR(found.next.interval[1], mean + t * deviation * std::sqrt(1.25), 2e-3 * deviation);
  for (std::size_t j = 0; j < 4; ++j)
    EXPECT_NEAR(found.members[j].interval[1], estimates[static_cast<Eigen::Index>(j)] + 1.96e-6, 1e-7);
}

// With errors of one size s, SS / (s^2 + tau^2) is chi-squared with n - 1 degrees of freedom, cut off at SS / s^2.
TEST(Population, SpreadBesideErrorsOfOneSizeIsTheClosedForm) {
  const double s = 1.5;
  for (const double apart : {0.5, 2.0, 6.0}) {
    const Eigen::VectorXd estimates = apart * Eigen::VectorXd{{-1.0, 0.2, 0.7, 1.4, -0.9}};
    const double squares = (estimates.array() - estimates.mean()).square().sum();
    const boost::math::chi_squared distribution(4.0);
    const double whole = boost::math::cdf(distribution, squares / (s * s));
    const auto spread = [&](double probability) {
      const double v = squares / boost::math::quantile(distribution, (1.0 - probability) * whole);
      return std::sqrt(v - s * s);
    };
    const auto found = population_of(members_at(estimates, s)).spread;
    EXPECT_NEAR(found.median, spread(0.5), 0.002 * spread(0.5)) << apart;
    EXPECT_NEAR(found.interval[0], spread(0.025), 0.002 * spread(0.025)) << apart;
    EXPECT_NEAR(found.interval[1], spread(0.975), 0.002 * spread(0.975)) << apart;
  }
}

TEST(Population, AMemberThatIsKnownWorseLeansOnTheOthers) {
  const auto found = population_of({{10.0, 0.1}, {10.3, 0.1}, {9.8, 0.1}, {10.1, 0.1}, {14.0, 4.0}});
  EXPECT_NEAR(found.members[4].median, 10.05, 0.2);
  EXPECT_LT(found.members[4].interval[1], 12.0);
  EXPECT_NEAR(found.members[0].median, 10.0, 0.1);
  EXPECT_NEAR(found.mean.median, 10.05, 0.1);
}

// Populations of 3 to 8 members, true numbers .3 to 10 times as far apart as the errors, which differ by a factor of 3.
TEST(Population, IntervalsHoldWhatTheySay) {
  const int runs = 600;
  int next = 0, mean = 0, spread = 0;
  for (int seed = 0; seed < runs; ++seed) {
    RandomStream stream(static_cast<std::uint64_t>(seed), "population");
    const auto count = 3 + static_cast<int>(6.0 * stream.uniform());
    const double tau = 0.3 * std::pow(33.0, stream.uniform());
    std::vector<PopulationMember> members;
    for (int j = 0; j < count; ++j) {
      const double s = std::pow(3.0, stream.uniform() - 0.5);
      members.push_back({5.0 + tau * stream.normal() + s * stream.normal(), s});
    }
    const auto found = population_of(members);
    const auto holds = [](const PopulationEstimate& told, double x) {
      return told.interval[0] <= x && x <= told.interval[1];
    };
    next += holds(found.next, 5.0 + tau * stream.normal());
    mean += holds(found.mean, 5.0);
    spread += holds(found.spread, tau);
  }
  std::printf("of %d populations hold: next %d, mean %d, spread %d\n", runs, next, mean, spread);
  const int least = 556, most = 583;  // 99 % of a count of 600 that each holds by 95 %
  for (const int held : {next, mean, spread}) {
    EXPECT_GE(held, least);
    EXPECT_LE(held, most);
  }
}

// Frequencies that fall with temperature, about which they scatter: seven to twenty records.
TEST(Population, ATrendHoldsItsSlope) {
  const int runs = 600;
  int slopes = 0, means = 0, spreads = 0;
  for (int seed = 0; seed < runs; ++seed) {
    RandomStream stream(static_cast<std::uint64_t>(seed), "trend");
    const auto count = 7 + static_cast<Eigen::Index>(14.0 * stream.uniform());
    const double tau = 0.3 * std::pow(10.0, stream.uniform()), slope = -0.2;
    const Eigen::MatrixXd temperature =
        Eigen::MatrixXd::NullaryExpr(count, 1, [&] { return 10.0 + 8.0 * stream.normal(); });
    std::vector<PopulationMember> members;
    for (const double T : temperature.reshaped()) {
      const double s = std::pow(3.0, stream.uniform() - 0.5);
      members.push_back({50.0 + slope * T + tau * stream.normal() + s * stream.normal(), s});
    }
    const auto found = population_trend(members, temperature);
    const auto holds = [](const PopulationEstimate& told, double x) {
      return told.interval[0] <= x && x <= told.interval[1];
    };
    slopes += holds(found.slopes[0], slope);
    means += holds(found.mean, 50.0 + slope * temperature.mean());
    spreads += holds(found.spread, tau);
  }
  std::printf("of %d trends hold: slope %d, mean %d, spread %d\n", runs, slopes, means, spreads);
  for (const int held : {slopes, means, spreads}) {
    EXPECT_GE(held, 556);
    EXPECT_LE(held, 590);  // a spread below the errors is held more often
  }
}

TEST(Population, ATrendOfExactEstimatesIsThatOfRegression) {
  const Eigen::VectorXd x{{1.0, 2.0, 4.0, 7.0, 8.0}}, t{{3.1, 3.9, 6.2, 8.8, 10.1}};
  const Eigen::VectorXd about = x.array() - x.mean();
  const double slope = about.dot(t) / about.squaredNorm();
  const Eigen::VectorXd rest = t.array() - t.mean() - slope * about.array();
  const double error = std::sqrt(rest.squaredNorm() / 3.0 / about.squaredNorm()) * student_t_quantile(0.975, 3.0);
  const auto found = population_trend(members_at(t, 1e-7), x);
  EXPECT_NEAR(found.slopes[0].median, slope, 1e-6);
  EXPECT_NEAR(found.slopes[0].interval[1], slope + error, 2e-3 * error);
  EXPECT_NEAR(found.mean.median, t.mean(), 1e-6);
}

TEST(Population, RefusesATrendThatCannotBeTold) {
  const Eigen::VectorXd same = Eigen::VectorXd::Ones(4), t{{1.0, 2.0, 3.0, 4.0}};
  EXPECT_THROW(population_trend(members_at(t, 0.1), same), InvalidInput);
  EXPECT_THROW(population_trend(members_at(t, 0.1), Eigen::MatrixXd::Random(3, 1)), InvalidInput);
  EXPECT_THROW(population_trend(members_at(t, 0.1), Eigen::MatrixXd::Random(4, 3)), InvalidInput);
}

TEST(Population, RefusesWhatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(population_of({{1.0, 0.1}}), InvalidInput);
  EXPECT_THROW(population_of({{1.0, 0.1}, {1.0, 0.0}}), InvalidInput);
  EXPECT_THROW(population_of({{1.0, 0.1}, {nan, 0.1}}), InvalidInput);
  EXPECT_THROW(population_of({{1.0, 0.1}, {1.0, nan}}), InvalidInput);
  EXPECT_THROW(population_of({{1.0, 0.1}, {1.0, 0.1}}, 1.0), InvalidInput);
}

}  // namespace
}  // namespace kalfem
