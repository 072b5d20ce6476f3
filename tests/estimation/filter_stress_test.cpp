// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/brute_force.hpp"
#include "kalfem/estimation/filter.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct StressSetting {
  FilterKind kind;
  UnscentedOptions options;
};

class AnyFilter : public testing::TestWithParam<StressSetting> {};

/// Maps that are bent far harder than a sigma point can see.
std::vector<FunctionMap::Function> hard_functions() {
  return {[](const VectorXd& w) { return VectorXd((5.0 * w.array()).tanh()); },
          [](const VectorXd& w) { return VectorXd(w.array().square() * w.array().sign()); },
          [](const VectorXd& w) { return VectorXd(w.array().sign()); },
          [](const VectorXd& w) { return VectorXd((20.0 * w.array()).cos()); },
          [](const VectorXd& w) { return VectorXd(w.array().abs().sqrt().inverse()); }};
}

TEST_P(AnyFilter, NeverGivesWhatIsNotANumberWithoutANamedOutcome) {
  RandomStream random(21, "stress");
  int completed = 0, stopped = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const Index n = 2 + trial % 5, l = 1 + trial % 2, q = 2;
    const auto functions = hard_functions();
    const auto& phi = functions[static_cast<std::size_t>(trial) % functions.size()];
    auto transition = random_map(random, n, n, q, q, phi);
    transition.linear *= 0.4;
    auto measurement = random_map(random, l, n, q, q, phi);
    const MatrixXd Q = 1e-4 * MatrixXd::Identity(n, n), R = 1e-2 * MatrixXd::Identity(l, l);
    const auto filter = make_filter(GetParam().kind, {transition, Q, measurement, R}, GetParam().options);
    filter->reset({VectorXd::Zero(n), MatrixXd::Identity(n, n)});
    bool usable = true;
    Innovation innovation;
    for (int k = 0; k < 60 && usable; ++k) {
      const VectorXd mean = filter->mean();
      const MatrixXd covariance = filter->covariance();
      auto outcome = filter->predict();
      usable = outcome == FilterOutcome::usable;
      if (!usable) {  // the estimate stays as it was, and the outcome has words
        EXPECT_EQ(filter->mean(), mean);
        EXPECT_EQ(filter->covariance(), covariance);
        EXPECT_GT(to_string(outcome).size(), 20u);
        break;
      }
      ASSERT_TRUE(filter->mean().allFinite());
      const VectorXd predicted = filter->mean();
      outcome = filter->update(random_matrix(random, l, 1), innovation);
      usable = outcome == FilterOutcome::usable;
      if (!usable) {
        EXPECT_EQ(filter->mean(), predicted);
        break;
      }
      ASSERT_TRUE(filter->mean().allFinite() && filter->standard_deviation().allFinite());
      // A linearised filter may run away until the squares overflow to infinity; that is still an answer.
      ASSERT_FALSE(std::isnan(innovation.nis) || std::isnan(innovation.log_likelihood));
      ASSERT_GE(innovation.nis, 0.0);
    }
    (usable ? completed : stopped) += 1;
  }
  RecordProperty("stopped", stopped);
  EXPECT_GT(completed, 0);
}

INSTANTIATE_TEST_SUITE_P(Spread, AnyFilter,
                         testing::Values(StressSetting{FilterKind::unscented, {}},
                                         StressSetting{FilterKind::unscented, {.alpha = 1e-3}},
                                         StressSetting{FilterKind::unscented, {.alpha = 0.3}},
                                         StressSetting{FilterKind::unscented_square_root, {}},
                                         StressSetting{FilterKind::unscented_square_root, {.alpha = 1e-3}},
                                         StressSetting{FilterKind::unscented_square_root, {.alpha = 0.1}},
                                         StressSetting{FilterKind::unscented_square_root, {.alpha = 0.5}},
                                         StressSetting{FilterKind::unscented_square_root, {.alpha = 1.0, .beta = -3.0}},
                                         StressSetting{FilterKind::extended, {}}));

TEST(Filters, SensorWithoutNoiseOrVarianceIsNamed) {
  RandomStream random(22, "noiseless");
  const auto same = [](const VectorXd& w) { return VectorXd(w); };
  auto process = random_map(random, 2, 2, 1, 1, same), map = random_map(random, 1, 2, 1, 1, same);
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended}) {
    const auto filter = make_filter(kind, {process, MatrixXd::Zero(2, 2), map, MatrixXd::Zero(1, 1)});
    filter->reset({VectorXd::Zero(2), MatrixXd::Zero(2, 2)});
    Innovation innovation;
    EXPECT_EQ(filter->update(VectorXd::Ones(1), innovation), FilterOutcome::innovation_not_positive_definite);
  }
}

TEST(Filters, CovarianceThatIsNoneIsNamed) {
  RandomStream random(23, "negative");
  auto map = random_map(random, 2, 2, 1, 1, [](const VectorXd& w) { return VectorXd(w); });
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended})
    for (const double variance : {-1.0, double(NAN), double(INFINITY)}) {
      const MatrixXd identity = MatrixXd::Identity(2, 2);
      const auto filter = make_filter(kind, {map, identity, map, identity});
      filter->reset({VectorXd::Zero(2), variance * MatrixXd::Identity(2, 2)});
      EXPECT_EQ(filter->predict(), FilterOutcome::covariance_not_positive_definite);
    }
}

}  // namespace
}  // namespace kalfem
