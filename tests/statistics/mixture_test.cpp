// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/mixture.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace kalfem {
namespace {

using Eigen::VectorXd;

TEST(Mixture, WeighsModelsHoweverSmallTheirEvidence) {
  const VectorXd weights = weights_of(VectorXd{{-5000.0, -5000.0 - std::log(3.0)}});
  EXPECT_NEAR(weights[0], 0.75, 1e-12);
  EXPECT_NEAR(weights[1], 0.25, 1e-12);
  EXPECT_EQ(weights_of(VectorXd{{-3.0, -std::numeric_limits<double>::infinity()}})[1], 0.0);
}

// Two points at -1 and +1 without deviations: variance 4 p (1 - p).
TEST(Mixture, HoldsTheSpreadBetweenModels) {
  const VectorXd low{{-1.0, 3.0}}, high{{1.0, 3.0}}, none{{0.0, 2.0}};
  const auto [mean, deviation] = mixture_of({{0.2, low, none}, {0.8, high, none}});
  EXPECT_NEAR(mean[0], 0.6, 1e-15);
  EXPECT_NEAR(deviation[0], 0.8, 1e-15);
  EXPECT_NEAR(mean[1], 3.0, 1e-15);  // models that agree keep what each leaves open
  EXPECT_NEAR(deviation[1], 2.0, 1e-15);
}

TEST(Mixture, LeavesModelsWithoutWeightOut) {
  const VectorXd own{{1.0}}, unknown{{std::numeric_limits<double>::quiet_NaN()}}, spread{{0.5}};
  const auto [mean, deviation] = mixture_of({{1.0, own, spread}, {0.0, unknown, unknown}});
  EXPECT_EQ(mean[0], 1.0);
  EXPECT_EQ(deviation[0], 0.5);
}

}  // namespace
}  // namespace kalfem
