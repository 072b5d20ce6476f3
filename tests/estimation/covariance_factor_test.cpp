// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/covariance_factor.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "estimation/brute_force.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index sizes[] = {1, 5, 30, 60, 90};  ///< below and above where the method changes

MatrixXd random_covariance(RandomStream& random, Index n, Index rank) {
  const MatrixXd root = random_matrix(random, n, rank);
  const VectorXd units = VectorXd::LinSpaced(n, -8.0, 3.0).unaryExpr([](double x) { return std::pow(10.0, x); });
  const MatrixXd scaled = units.asDiagonal() * root;
  return scaled * scaled.transpose();
}

/// Error of S S^T in units of the standard deviations.
double relative_error(const MatrixXd& P, const MatrixXd& S) {
  const VectorXd deviation = P.diagonal().cwiseSqrt();
  return ((S * S.transpose() - P).array() / (deviation * deviation.transpose()).array().max(1e-300)).abs().maxCoeff();
}

TEST(CovarianceFactor, RegularMatricesOfMixedUnits) {
  RandomStream random(1, "regular");
  for (const Index n : sizes) {
    const MatrixXd P = random_covariance(random, n, n + 3);
    MatrixXd S;
    ASSERT_TRUE(covariance_factor(P, S)) << n;
    // rounding of sums of up to n products
    EXPECT_LT(relative_error(P, S), 1e-14) << n;
    EXPECT_TRUE(S.isLowerTriangular()) << n;
  }
}

TEST(CovarianceFactor, OnlyTheLowerTriangleIsRead) {
  RandomStream random(2, "lower");
  for (const Index n : {5, 60}) {
    const MatrixXd P = random_covariance(random, n, n + 3);
    MatrixXd half = P, S;
    half.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
    ASSERT_TRUE(covariance_factor(half, S));
    EXPECT_LT(relative_error(P, S), 1e-14);  // rounding
  }
}

TEST(CovarianceFactor, SingularMatricesAndKnownStates) {
  RandomStream random(3, "singular");
  for (const Index n : {5, 30, 60}) {
    MatrixXd P = random_covariance(random, n, n / 2);
    P.row(n / 3).setZero();
    P.col(n / 3).setZero();
    MatrixXd S;
    ASSERT_TRUE(covariance_factor(P, S)) << n;
    EXPECT_LT(relative_error(P, S), 1e-7) << n;  // directions of 1e-13 variance may be dropped: 3e-7 of a deviation
    EXPECT_EQ(S.row(n / 3).norm(), 0.0) << n;
  }
  MatrixXd S;
  ASSERT_TRUE(covariance_factor(MatrixXd::Zero(4, 4), S));
  EXPECT_EQ(S.norm(), 0.0);
}

TEST(CovarianceFactor, IndefiniteMatricesAreRefused) {
  RandomStream random(4, "indefinite");
  for (const Index n : {2, 5, 30, 60}) {
    MatrixXd P = random_covariance(random, n, n + 3), S;
    P(n - 1, 0) = P(0, n - 1) = 1.01 * std::sqrt(P(0, 0) * P(n - 1, n - 1));  // a correlation above 1
    EXPECT_FALSE(covariance_factor(P, S)) << n;
    P = MatrixXd::Identity(n, n);
    P(n / 2, n / 2) = -1e-20;
    EXPECT_FALSE(covariance_factor(P, S)) << n;
  }
}

TEST(CovarianceFactor, WhatIsNotFiniteIsRefused) {
  for (const Index n : {1, 5, 60})
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      MatrixXd P = MatrixXd::Identity(n, n), S;
      P(n - 1, n - 1) = bad;
      EXPECT_FALSE(covariance_factor(P, S)) << n << " " << bad;
      P = MatrixXd::Identity(n, n);
      P(n - 1, 0) = bad;
      EXPECT_FALSE(covariance_factor(P, S)) << n << " " << bad;
    }
}

TEST(Triangularise, KeepsTheSumOfProductsWithAPositiveDiagonal) {
  RandomStream random(5, "qr");
  const MatrixXd columns = random_matrix(random, 6, 17);
  MatrixXd array = columns.transpose(), lower;
  triangularise(array, lower);
  EXPECT_TRUE(lower.isLowerTriangular());
  EXPECT_GE(lower.diagonal().minCoeff(), 0.0);
  // rounding
  EXPECT_LT((lower * lower.transpose() - columns * columns.transpose()).norm(), 2e-15 * columns.squaredNorm());
}

TEST(Downdate, TakesAVectorOff) {
  RandomStream random(6, "downdate");
  const MatrixXd root = random_matrix(random, 7, 12);
  const VectorXd vector = 0.3 * random_matrix(random, 7, 1);
  MatrixXd lower = (root * root.transpose() + vector * vector.transpose()).llt().matrixL();
  ASSERT_TRUE(downdate(lower, vector));
  EXPECT_TRUE(lower.isLowerTriangular());
  // rounding
  EXPECT_LT((lower * lower.transpose() - root * root.transpose()).norm(), 2e-15 * root.squaredNorm());
}

TEST(Downdate, RefusesToLeaveThePositiveDefiniteMatrices) {
  const MatrixXd before = MatrixXd::Identity(3, 3);
  for (const VectorXd& vector : {VectorXd(VectorXd::Constant(3, 0.6)), VectorXd(VectorXd::Unit(3, 2)),
                                 VectorXd(VectorXd::Constant(3, std::numeric_limits<double>::quiet_NaN()))}) {
    MatrixXd lower = before;
    EXPECT_FALSE(downdate(lower, vector));
    EXPECT_EQ(lower, before);
  }
  MatrixXd singular = MatrixXd::Zero(2, 2);
  EXPECT_FALSE(downdate(singular, VectorXd::Constant(2, 1e-9)));
  EXPECT_TRUE(downdate(singular, VectorXd::Zero(2)));
}

}  // namespace
}  // namespace kalfem
