// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/student_mixture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kalfem {
namespace {

const NormalApproximation standard{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1)};
const NormalApproximation oblique{Eigen::Vector2d(1.0, -2.0), Eigen::Matrix2d{{4.0, 1.0}, {1.0, 1.0}}};

TEST(StudentDistribution, DensitiesInClosedForm) {
  const Eigen::VectorXd two = Eigen::VectorXd::Constant(1, 2.0);
  EXPECT_NEAR(StudentDistribution(standard, 1).log_density(two), -std::log(5.0 * std::numbers::pi), 1e-13);  // Cauchy
  EXPECT_NEAR(StudentDistribution(standard, 0).log_density(two), -2.0 - 0.5 * std::log(2.0 * std::numbers::pi), 1e-13);
  // nu = 2, p = 2: 1 / (2 pi det(S)^(1/2)) (1 + q / 2)^-2, here with q = 4 / 3 and det S = 3
  const Eigen::Vector2d z(1.0, -1.0);
  EXPECT_NEAR(StudentDistribution(oblique, 2).log_density(z),
              -std::log(2.0 * std::numbers::pi * std::sqrt(3.0)) - 2.0 * std::log(1.0 + 2.0 / 3.0), 1e-13);
  EXPECT_NEAR(StudentDistribution(oblique, 0).log_density(z),
              -std::log(2.0 * std::numbers::pi * std::sqrt(3.0)) - 2.0 / 3.0, 1e-13);
}

TEST(StudentDistribution, DrawsHaveItsMoments) {
  for (const int degrees : {0, 10}) {
    const StudentDistribution distribution(oblique, degrees);
    RandomStream random(3, "student");
    constexpr int count = 40000;
    Eigen::MatrixXd z(2, count);
    for (int k = 0; k < count; ++k) z.col(k) = distribution.draw(random);
    const Eigen::Vector2d mean = z.rowwise().mean();
    const Eigen::MatrixXd centred = z.colwise() - mean;
    const double variance = degrees == 0 ? 1.0 : degrees / (degrees - 2.0);
    EXPECT_LT((mean - oblique.mean).norm(), 0.04);
    EXPECT_LT((centred * centred.transpose() / count - variance * oblique.covariance).norm(), 0.15);
  }
}

TEST(StudentMixture, DrawsFromEachComponentAsOftenAsItsShare) {
  const auto at = [](double mean) {
    return StudentDistribution({Eigen::VectorXd::Constant(1, mean), 1e-6 * Eigen::MatrixXd::Identity(1, 1)}, 0);
  };
  const StudentMixture mixture{.components = {at(0.0), at(10.0), at(20.0)}, .shares = {0.2, 0.5, 0.3}};
  RandomStream random(1, "mixture");
  Eigen::Vector3i counts = Eigen::Vector3i::Zero();
  for (int k = 0; k < 100; ++k)
    ++counts[static_cast<Eigen::Index>(std::lround(mixture.draw((k + 0.5) / 100.0, random)[0] / 10.0))];
  EXPECT_EQ(counts, Eigen::Vector3i(20, 50, 30));
  EXPECT_NEAR(mixture.log_density(Eigen::VectorXd::Constant(1, 10.0)),
              std::log(0.5) - 0.5 * std::log(2.0 * std::numbers::pi * 1e-6), 1e-12);
}

}  // namespace
}  // namespace kalfem
