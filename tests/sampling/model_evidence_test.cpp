// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/sampling/evidence.hpp"

namespace kalfem {
namespace {

TEST(ModelEvidence, ProbabilitiesHoldFarBelowTheRangeOfDoubles) {
  const Eigen::VectorXd near = model_probabilities(Eigen::Vector3d(-1e6, -1e6 + std::log(2.0), -1.1e6));
  EXPECT_NEAR(near[0], 1.0 / 3.0, 1e-9);  // ln 2 beside 1e6 is rounded to 1e-10
  EXPECT_NEAR(near[1], 2.0 / 3.0, 1e-9);
  EXPECT_EQ(near[2], 0.0);
  const Eigen::VectorXd far = model_probabilities(Eigen::Vector2d(-1e6, -9e5));
  EXPECT_EQ(far[0], 0.0);
  EXPECT_EQ(far[1], 1.0);
}

TEST(ModelEvidence, PriorsWeighModels) {
  const Eigen::VectorXd p = model_probabilities(Eigen::Vector2d(-5.0, -5.0), Eigen::Vector2d(3.0, 1.0));
  EXPECT_NEAR(p[0], 0.75, 1e-14);
  EXPECT_EQ(model_probabilities(Eigen::Vector2d(-5.0, -INFINITY))[1], 0.0);
  EXPECT_THROW(model_probabilities(Eigen::Vector2d(-5.0, NAN)), InvalidInput);
  EXPECT_THROW(model_probabilities(Eigen::Vector2d(-INFINITY, -INFINITY)), InvalidInput);
  EXPECT_THROW(model_probabilities(Eigen::Vector2d(-5.0, -5.0), Eigen::Vector3d(1.0, 1.0, 1.0)), InvalidInput);
}

TEST(ModelEvidence, BayesFactorsInWords) {
  EXPECT_EQ(kass_raftery(0.5), "not worth more than a bare mention");
  EXPECT_EQ(kass_raftery(2.0), "positive");
  EXPECT_EQ(kass_raftery(-4.0), "strong");
  EXPECT_EQ(kass_raftery(1e5), "very strong");
}

}  // namespace
}  // namespace kalfem
