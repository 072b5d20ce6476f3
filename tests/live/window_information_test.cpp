// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/window_information.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The posterior of a prior and of data with an information and an estimate of their own.
Gaussian posterior(const Gaussian& prior, const MatrixXd& information, const VectorXd& estimate) {
  const MatrixXd covariance = (prior.covariance.inverse() + information).inverse();
  return {covariance * (prior.covariance.inverse() * prior.mean + information * estimate), covariance};
}

TEST(WindowInformation, IsThatOfTheDataWhateverWasKnownBefore) {
  MatrixXd information(3, 3), spread(3, 3);
  information << 4e4, 1e4, 0, 1e4, 9e4, -2e4, 0, -2e4, 1e4;
  const VectorXd estimate = VectorXd::LinSpaced(3, -0.01, 0.02);
  spread << 1, 0.3, 0, 0.3, 2, -0.4, 0, -0.4, 1.5;
  for (const double scale : {1e-2, 1e-5, 1e-9}) {
    const Gaussian before{VectorXd::Constant(3, 0.003), scale * spread};
    const auto found = window_information(before, VectorXd::Zero(3), posterior(before, information, estimate));
    const double tolerance = 1e-12 / scale + 1e-6 * information.norm();
    EXPECT_LT((found.information - information).norm(), tolerance);
    EXPECT_LT((found.weighted - information * estimate).norm(), tolerance);
  }
}

TEST(WindowInformation, TakesAWalkOut) {
  const MatrixXd information = MatrixXd::Identity(2, 2) * 1e4;
  const VectorXd estimate = VectorXd::Constant(2, 0.01), walk = VectorXd::Constant(2, 3e-5);
  const Gaussian before{VectorXd::Zero(2), MatrixXd::Identity(2, 2) * 1e-4};
  Gaussian wider = before;
  wider.covariance.diagonal() += walk;
  const auto found = window_information(before, walk, posterior(wider, information, estimate));
  EXPECT_LT((found.information - information).norm(), 1e-6);
  EXPECT_LT((found.weighted - information * estimate).norm(), 1e-8);
}

TEST(WindowInformation, HasNoneOfWhatTheDataDoNotTell) {
  MatrixXd information = MatrixXd::Zero(2, 2);
  information(0, 0) = 1e4;
  const Gaussian before{VectorXd::Zero(2), MatrixXd::Identity(2, 2)};
  const auto found = window_information(before, VectorXd::Zero(2), posterior(before, information, VectorXd::Ones(2)));
  EXPECT_NEAR(found.information(0, 0), 1e4, 1e-3);
  EXPECT_EQ(found.information(1, 1), 0.0);
  EXPECT_EQ(found.weighted[1], 0.0);
}

}  // namespace
}  // namespace kalfem
