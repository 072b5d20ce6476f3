// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/robust_statistics.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "kalfem/base/random.hpp"
#include "updating/function_residual.hpp"

// Regressions whose errors are not what parameter_statistics() takes them for.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// First-order autoregression of variance one.
VectorXd coloured(RandomStream& random, Index samples, double rho) {
  VectorXd errors(samples);
  double state = random.normal();
  for (double& error : errors) error = state = rho * state + std::sqrt(1.0 - rho * rho) * random.normal();
  return errors;
}

struct Deviations {
  VectorXd stated, robust, estimate;
};

/// Least squares of J theta = errors, whose truth is theta = 0.
Deviations regression(const MatrixXd& jacobian, const VectorXd& errors, const RowLayout& layout) {
  const VectorXd theta = jacobian.colPivHouseholderQr().solve(errors);
  auto parameters = free_parameters(VectorXd::Ones(theta.size()));
  const ResidualValue value{jacobian * theta - errors, jacobian};
  const auto statistics = parameter_statistics(parameters, theta, value);
  const auto robust = robust_statistics(parameters, value, {{"all", 0, errors.size(), layout}}, statistics);
  return {statistics.deviations, robust.deviations, theta};
}

/// Slow sines: a constant, and a period of 200 and 300 samples.
MatrixXd slow_regressors(Index samples) {
  MatrixXd jacobian(samples, 3);
  for (Index k = 0; k < samples; ++k)
    jacobian.row(k) << 1.0, std::sin(0.0314 * static_cast<double>(k)), std::cos(0.0209 * static_cast<double>(k));
  return jacobian;
}

/// Median over seeds of std and std_robust over the scatter of the estimates, by parameter.
struct Ratios {
  double stated, robust;
};
Ratios ratios_over_seeds(Index parameter, const std::function<Deviations(RandomStream&)>& draw) {
  std::vector<double> stated, robust;
  double squares = 0.0;
  constexpr int seeds = 100;
  for (int seed = 1; seed <= seeds; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed), "regression");
    const Deviations found = draw(random);
    stated.push_back(found.stated[parameter]);
    robust.push_back(found.robust[parameter]);
    squares += found.estimate[parameter] * found.estimate[parameter];
  }
  const double scatter = std::sqrt(squares / seeds);
  return {median(stated) / scatter, median(robust) / scatter};
}

TEST(RobustStatistics, AllowForErrorsThatAreCorrelatedInTime) {
  const Index samples = 3000;
  const MatrixXd jacobian = slow_regressors(samples);
  for (Index parameter = 0; parameter < 3; ++parameter) {
    const auto [stated, robust] = ratios_over_seeds(parameter, [&](RandomStream& random) {
      return regression(jacobian, coloured(random, samples, 0.9), layout_of_series(samples, 1));
    });
    EXPECT_LT(stated, 0.4) << parameter;         // 1 / sqrt(1.9 / 0.1) = 0.23 of the constant
    EXPECT_NEAR(robust, 1.0, 0.2) << parameter;  // of 100 seeds: the scatter is known to 7 %
  }
}

TEST(RobustStatistics, AgreeWithStatedOnesWhereTheModelIsTrue) {
  const Index samples = 3000;
  const MatrixXd jacobian = slow_regressors(samples);
  for (const bool ordered : {true, false}) {
    std::vector<double> ratios;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      RandomStream random(seed, "white");
      auto layout = layout_of_series(samples, 1);
      layout.ordered = ordered;
      const auto found = regression(jacobian, coloured(random, samples, 0.0), layout);
      for (Index i = 0; i < 3; ++i) ratios.push_back(found.robust[i] / found.stated[i]);
    }
    EXPECT_NEAR(median(ratios), 1.0, 0.05) << ordered;
  }
}

/// A few modes, each worth a value: the adjustment makes up for what the fit takes from the residuals.
TEST(RobustStatistics, OfFewValuesAreNotTooSmall) {
  RandomStream design(1, "design");
  MatrixXd jacobian(12, 3);
  for (double& entry : jacobian.reshaped()) entry = design.normal();
  RowLayout layout{.steps = "modes"};
  for (Index i = 0; i < 12; ++i) layout.step.push_back(i);
  for (Index parameter = 0; parameter < 3; ++parameter) {
    double robust = 0.0, squares = 0.0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
      RandomStream random(seed, "modes");
      const auto found = regression(jacobian, coloured(random, 12, 0.0), layout);
      robust += found.robust[parameter] * found.robust[parameter];
      squares += found.estimate[parameter] * found.estimate[parameter];
    }
    EXPECT_NEAR(std::sqrt(robust / squares), 1.0, 0.06);  // without the adjustment 0.84
  }
}

/// The mean over groups of equal size: CR2 is the standard deviation of the groups' means over the root of their
/// number.
TEST(RobustStatistics, OfAMeanOverGroupsInClosedForm) {
  const Index groups = 7, size = 20;
  RandomStream random(1, "groups");
  VectorXd errors(groups * size), means(groups);
  RowLayout layout{.steps = "modes"};
  for (Index g = 0; g < groups; ++g) {
    const double own = 10.0 * random.normal();
    for (Index i = 0; i < size; ++i) {
      errors[g * size + i] = own + 0.3 * random.normal();
      layout.step.push_back(g);
    }
    means[g] = errors.segment(g * size, size).mean();
  }
  const auto found = regression(MatrixXd::Ones(groups * size, 1), errors, layout);
  const double expected = std::sqrt((means.array() - means.mean()).square().sum() / (groups - 1) / groups);
  EXPECT_NEAR(found.robust[0], expected, 1e-12);
  EXPECT_LT(found.stated[0], 0.4 * found.robust[0]);
}

/// Eight sensors, each with an error of its own that is constant in time.
TEST(RobustStatistics, SeeTheScatterBetweenSensors) {
  const Index samples = 400, sensors = 8;
  const auto [stated, robust] = ratios_over_seeds(0, [&](RandomStream& random) {
    VectorXd errors(samples * sensors);
    for (Index j = 0; j < sensors; ++j) {
      const double own = random.normal();
      for (Index k = 0; k < samples; ++k) errors[j * samples + k] = own + random.normal();
    }
    return regression(MatrixXd::Ones(samples * sensors, 1), errors, layout_of_series(samples, sensors));
  });
  EXPECT_LT(stated, 0.1);
  EXPECT_NEAR(robust, 1.0, 0.25);
}

TEST(RobustStatistics, AreNoneForWhatIsHeldAndWhereNothingScatters) {
  RandomStream random(1, "none");
  MatrixXd jacobian(50, 3);
  for (double& entry : jacobian.reshaped()) entry = random.normal();
  auto parameters = free_parameters(VectorXd::Ones(3));
  parameters[1].lower = parameters[1].upper = 1.0;
  parameters[2].lower = 1.0;
  VectorXd residual = coloured(random, 50, 0.0);
  residual += 10.0 * jacobian.col(2);  // pulls p3 down, below its bound
  const ResidualValue value{residual, jacobian};
  const auto statistics = parameter_statistics(parameters, VectorXd::Ones(3), value);
  ASSERT_TRUE(statistics.at_bound[2]);
  const auto robust = robust_statistics(parameters, value, {{"all", 0, 50, layout_of_series(50, 1)}}, statistics);
  EXPECT_TRUE(robust.exist());
  EXPECT_EQ(robust.rank, 1);
  EXPECT_GT(robust.deviations[0], 0.0);
  EXPECT_TRUE(std::isnan(robust.deviations[1]));
  EXPECT_TRUE(std::isnan(robust.deviations[2]));

  const auto few = free_parameters(VectorXd::Ones(3));
  const ResidualValue square{VectorXd::Ones(3), jacobian.topRows(3)};
  RowLayout layout{.step = {0, 1, 2}, .steps = "modes"};
  const auto none =
      robust_statistics(few, square, {{"all", 0, 3, layout}}, parameter_statistics(few, VectorXd::Ones(3), square));
  EXPECT_FALSE(none.exist());
  EXPECT_TRUE(none.deviations.array().isNaN().all());
  EXPECT_NE(none.none.find("3 parameters"), std::string::npos) << none.none;
}

/// The prior counts as stated; its part of the variance is not taken from the residuals.
TEST(RobustStatistics, KeepThePriorsPart) {
  RandomStream random(1, "prior");
  auto parameters = free_parameters(VectorXd::Ones(1));
  parameters[0].deviation = 0.5;
  const MatrixXd jacobian = MatrixXd::Constant(200, 1, 1e-3);
  const ResidualValue value{coloured(random, 200, 0.0), jacobian};
  const auto statistics = parameter_statistics(parameters, VectorXd::Ones(1), value);
  const auto robust = robust_statistics(parameters, value, {{"all", 0, 200, layout_of_series(200, 1)}}, statistics);
  EXPECT_NEAR(robust.deviations[0], 0.5, 1e-3);
}

}  // namespace
}  // namespace kalfem
