// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/unscented_transform.hpp"

#include <gtest/gtest.h>
#include <cmath>

#include "estimation/brute_force.hpp"

namespace kalfem {
namespace {

/// Where the case does not say: points of the channels stand sqrt(3) deviations out whatever their number, points of
/// the state sqrt(n).
TEST(UnscentedWeights, HaveTheSpreadOfTheirKind) {
  for (const Eigen::Index n : {1, 2, 5, 9}) {
    // rounding of a root
    EXPECT_NEAR(UnscentedWeights({.points = SigmaPoints::of_arguments}, n).spread, std::sqrt(3.0), 1e-14) << n;
    EXPECT_NEAR(UnscentedWeights({}, n).spread, std::sqrt(double(n)), 1e-14) << n;
    EXPECT_NEAR(UnscentedWeights({.alpha = 0.5, .kappa = 2.0}, n).spread, 0.5 * std::sqrt(double(n) + 2.0), 1e-14) << n;
    for (const double alpha : {1.0, 0.3}) {
      const UnscentedWeights weights({.alpha = alpha, .beta = 1.5, .kappa = 0.7}, n);
      EXPECT_NEAR(weights.mean_centre + 2.0 * double(n) * weights.other, 1.0, 1e-14);
      EXPECT_NEAR(weights.other * weights.spread * weights.spread, 0.5, 1e-14);
      EXPECT_NEAR(weights.covariance_centre - weights.mean_centre, 1.0 - alpha * alpha + 1.5, 1e-15);
    }
  }
}

struct PointSetting {
  UnscentedOptions options;
  double tolerance;  ///< relative
};

class TableOne : public testing::TestWithParam<PointSetting> {};

TEST_P(TableOne, EqualsTheSumOverAllPoints) {
  const auto& [options, tolerance] = GetParam();
  RandomStream random(7, "table 1");
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Index n = 5 + trial % 3, n_y = 4;
    auto map = random_map(random, n_y, n, 3, 2, bent);
    const Eigen::VectorXd m = random_matrix(random, n, 1);
    Eigen::MatrixXd S = random_matrix(random, n, n);
    if (trial % 2) S = Eigen::MatrixXd(S.triangularView<Eigen::Lower>());
    const auto expected = table_1(map, m, S, options);
    UnscentedTransform transform(options);
    ASSERT_TRUE(transform.apply(map, m, S));
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n_y, n_y);
    transform.add_covariance(map, covariance);
    const Eigen::MatrixXd full = covariance.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd cross = S * transform.deviations().transpose();
    EXPECT_LT((transform.mean() - expected.mean).norm(), tolerance * expected.mean.norm());
    EXPECT_LT((full - expected.covariance).norm(), tolerance * expected.covariance.norm());
    EXPECT_LT((cross - expected.cross).norm(), tolerance * expected.cross.norm());
  }
}

// Centre weights: 0, negative, positive, negative through kappa, and of the size 1e4, which costs four
// digits. Tolerances are rounding, of sums over the points.
INSTANTIATE_TEST_SUITE_P(Weights, TableOne,
                         testing::Values(PointSetting{{1.0, 2.0, 0.0}, 3e-13}, PointSetting{{0.5, 2.0, 0.0}, 3e-13},
                                         PointSetting{{1.0, 0.0, 3.0}, 3e-13}, PointSetting{{1.0, 2.0, -3.0}, 3e-13},
                                         PointSetting{{0.7, 1.0, -2.0}, 3e-13}, PointSetting{{1e-2, 2.0, 0.0}, 1e-9}));

TEST(UnscentedTransform, CovarianceIsAddedToWhatIsThere) {
  RandomStream random(8, "added");
  auto map = random_map(random, 2, 3, 3, 2, bent);
  UnscentedTransform transform;
  ASSERT_TRUE(transform.apply(map, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()));
  Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(2, 2), noise = Eigen::MatrixXd::Identity(2, 2);
  transform.add_covariance(map, zero);
  transform.add_covariance(map, noise);
  // one sum
  EXPECT_NEAR(noise(1, 0), zero(1, 0), 1e-14);
  EXPECT_NEAR(noise(1, 1), zero(1, 1) + 1.0, 1e-14);
}

TEST(UnscentedTransform, QuadraticOfAGaussianHasItsExactMeanAndVariance) {
  // y = x^2, x ~ N(m, s^2): mean m^2 + s^2, variance 4 m^2 s^2 + 2 s^4; exact for alpha = 1, beta = 0, kappa = 2, and
  // the mean for any weights.
  FunctionMap square([](const Eigen::VectorXd& w) { return Eigen::VectorXd(w.cwiseAbs2()); });
  square.linear = Eigen::MatrixXd::Zero(1, 1);
  square.gain = square.selection = Eigen::MatrixXd::Identity(1, 1);
  square.offset = square.input_offset = Eigen::VectorXd::Zero(1);
  const double m = 1.3, s = 0.4;
  UnscentedTransform transform({.alpha = 1.0, .beta = 0.0, .kappa = 2.0});
  ASSERT_TRUE(transform.apply(square, Eigen::VectorXd::Constant(1, m), Eigen::MatrixXd::Constant(1, 1, s)));
  Eigen::MatrixXd variance = Eigen::MatrixXd::Zero(1, 1);
  transform.add_covariance(square, variance);
  // rounding
  EXPECT_NEAR(transform.mean()[0], m * m + s * s, 2e-15);
  EXPECT_NEAR(variance(0, 0), 4 * m * m * s * s + 2 * s * s * s * s, 3e-15);
}

TEST(UnscentedTransform, LinearisedIsTheJacobian) {
  RandomStream random(9, "jacobian");
  auto map = random_map(random, 3, 4, 3, 2, bent);
  const Eigen::VectorXd m = random_matrix(random, 4, 1);
  const Eigen::MatrixXd S = random_matrix(random, 4, 4);
  auto transform = UnscentedTransform::linearised();
  ASSERT_TRUE(transform.apply(map, m, S));
  EXPECT_LT((transform.mean() - map(m)).norm(), 1e-15);  // the centre itself
  Eigen::MatrixXd jacobian(3, 4);
  const double h = 1e-5;
  for (Eigen::Index i = 0; i < 4; ++i)
    jacobian.col(i) = (map(m + h * Eigen::VectorXd::Unit(4, i)) - map(m - h * Eigen::VectorXd::Unit(4, i))) / (2 * h);
  // two central differences, each with a truncation of the square of its step
  EXPECT_LT((transform.deviations() - jacobian * S).norm(), 3e-8 * (jacobian * S).norm());
  EXPECT_EQ(transform.scatter().norm(), 0.0);
}

TEST(UnscentedTransform, MapThatCannotBeEvaluatedIsAnAnswer) {
  RandomStream random(10, "nan");
  auto map = random_map(random, 2, 2, 1, 1, [](const Eigen::VectorXd& w) { return Eigen::VectorXd(w.array().log()); });
  UnscentedTransform transform;
  EXPECT_FALSE(transform.apply(map, Eigen::Vector2d::Zero(), 100.0 * Eigen::Matrix2d::Identity()));
}

}  // namespace
}  // namespace kalfem
