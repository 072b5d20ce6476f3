// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "updating/function_residual.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// r = [theta_1^2 - 3; theta_1 theta_2].
FunctionResidual curved() {
  return {2, [](const VectorXd& theta) {
            ResidualValue value{VectorXd(2), MatrixXd(2, 2)};
            value.values << theta[0] * theta[0] - 3.0, theta[0] * theta[1];
            value.jacobian << 2.0 * theta[0], 0.0, theta[1], theta[0];
            return value;
          }};
}

ResidualSum weighted(double first, double second) {
  return ResidualSum({{std::make_shared<FunctionResidual>(curved()), first},
                      {std::make_shared<FunctionResidual>(rosenbrock()), second}});
}

const VectorXd theta = (VectorXd(2) << 1.3, -0.7).finished();

/// |r|^2 of the sum is w_1 |r_1|^2 + w_2 |r_2|^2, so each part counts with the root of its weight.
TEST(ResidualSum, WeighsSumsOfSquares) {
  const auto sum = weighted(9.0, 0.25).evaluate(theta, false);
  ASSERT_TRUE(sum);
  const VectorXd first = curved().evaluate(theta, false)->values, second = rosenbrock().evaluate(theta, false)->values;
  // rounding
  EXPECT_NEAR(sum->values.squaredNorm(), 9.0 * first.squaredNorm() + 0.25 * second.squaredNorm(), 1e-13);
  EXPECT_LT((sum->values.head(2) - 3.0 * first).norm(), 1e-14);
  EXPECT_LT((sum->values.tail(2) - 0.5 * second).norm(), 1e-14);
  EXPECT_EQ(sum->jacobian.size(), 0);
  EXPECT_EQ(weighted(9.0, 0.25).size(), 4);
}

/// The gradient of the sum, J^T r, is that of its cost; differences of 1e-6 leave 1e-9.
TEST(ResidualSum, GradientIsThatOfDifferences) {
  for (const auto& [first, second] : {std::pair{9.0, 0.25}, std::pair{1.0, 1.0}, std::pair{0.0, 4.0}}) {
    const auto sum = weighted(first, second);
    const auto cost = [&](const VectorXd& at) { return 0.5 * sum.evaluate(at, false)->values.squaredNorm(); };
    const auto value = *sum.evaluate(theta, true);
    const VectorXd gradient = value.jacobian.transpose() * value.values;
    for (Index i = 0; i < 2; ++i) {
      const VectorXd step = 1e-6 * VectorXd::Unit(2, i);
      const double difference = (cost(theta + step) - cost(theta - step)) / 2e-6;
      EXPECT_NEAR(gradient[i], difference, 1e-9 * (1.0 + std::abs(difference))) << first << " " << second;
    }
  }
}

TEST(ResidualSum, HasNoValueWhereOneOfItsPartsHasNone) {
  const auto none =
      std::make_shared<FunctionResidual>(3, [](const VectorXd&) { return std::optional<ResidualValue>(); });
  EXPECT_FALSE(ResidualSum({{std::make_shared<FunctionResidual>(curved()), 1.0}, {none, 1.0}}).evaluate(theta, true));
}

}  // namespace
}  // namespace kalfem
