#include "kalfem/estimation/partially_linear/argument_factor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kalfem {
namespace {

using Eigen::MatrixXd;

MatrixXd factor_of(const MatrixXd& covariance) {
  MatrixXd factor;
  EXPECT_TRUE(argument_factor(covariance, factor));
  return factor;
}

TEST(ArgumentFactor, IsTheCholeskyFactorOfAGoodCovariance) {
  MatrixXd covariance(3, 3);
  covariance << 4e-12, 1e-9, -2e-7, 1e-9, 1e-6, 3e-5, -2e-7, 3e-5, 9.0;
  const MatrixXd factor = factor_of(covariance);
  EXPECT_TRUE((factor * factor.transpose()).isApprox(covariance, 1e-14));
}

TEST(ArgumentFactor, SpreadsAlongArgumentsThatDependOnEachOther) {
  MatrixXd covariance(2, 2);
  covariance << 1.0, 2.0, 2.0, 4.0;
  const MatrixXd factor = factor_of(covariance);
  EXPECT_TRUE((factor * factor.transpose()).isApprox(covariance, 1e-11));
  EXPECT_GT(factor(1, 1), 0.0);
}

/// What rounding left of a certain argument, 1e-33 beside covariances of 1e-20, must not grow into slopes of 1e+13.
TEST(ArgumentFactor, DrawsNothingFromAVarianceThatIsRounding) {
  MatrixXd covariance(2, 2);
  covariance << 1e-33, 1e-20, 1e-20, 1e-10;
  const MatrixXd factor = factor_of(covariance);
  EXPECT_EQ(factor(1, 0), 0.0);
  EXPECT_NEAR(factor(1, 1), 1e-5, 1e-15);
  EXPECT_GT(factor(0, 0), 0.0);
}

TEST(ArgumentFactor, RefusesWhatIsNoCovariance) {
  MatrixXd factor;
  EXPECT_FALSE(argument_factor(MatrixXd::Constant(1, 1, -1e-3), factor));
  EXPECT_FALSE(argument_factor(MatrixXd::Constant(1, 1, std::numeric_limits<double>::quiet_NaN()), factor));
  EXPECT_TRUE(argument_factor(MatrixXd::Zero(1, 1), factor));
  EXPECT_EQ(factor(0, 0), 0.0);
}

}  // namespace
}  // namespace kalfem
