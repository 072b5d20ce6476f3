// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/discretisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

Eigen::VectorXd derivative(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::VectorXd& x,
                           const Eigen::VectorXd& u) {
  return A * x + B * u;
}

/// Classical Runge-Kutta over the interval with an input that is linear in time.
Eigen::VectorXd runge_kutta(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, Eigen::VectorXd x,
                            const Eigen::VectorXd& u0, const Eigen::VectorXd& u1, double h, int steps) {
  const double dt = h / steps;
  for (int k = 0; k < steps; ++k) {
    const Eigen::VectorXd begin = u0 + (u1 - u0) * (double(k) / steps);
    const Eigen::VectorXd middle = u0 + (u1 - u0) * ((k + 0.5) / steps);
    const Eigen::VectorXd end = u0 + (u1 - u0) * ((k + 1.0) / steps);
    const Eigen::VectorXd k1 = derivative(A, B, x, begin);
    const Eigen::VectorXd k2 = derivative(A, B, x + 0.5 * dt * k1, middle);
    const Eigen::VectorXd k3 = derivative(A, B, x + 0.5 * dt * k2, middle);
    const Eigen::VectorXd k4 = derivative(A, B, x + dt * k3, end);
    x += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return x;
}

TEST(FirstOrderHold, DoubleIntegratorUnderARampHasItsClosedForm) {
  const Eigen::Matrix2d A{{0, 1}, {0, 0}};
  const Eigen::Vector2d B{0, 1};
  const double h = 0.3;
  const auto step = first_order_hold(A, B, h);
  const double rounding = 2e-15;
  // x'' = u0 + (u1 - u0) t / h  ->  v = h (u0 + u1) / 2,  x = h^2 (2 u0 + u1) / 6
  EXPECT_NEAR(step.transition(0, 1) / h, 1.0, rounding);
  EXPECT_NEAR(step.begin_weight(0) / (h * h / 3), 1.0, rounding);
  EXPECT_NEAR(step.end_weight(0) / (h * h / 6), 1.0, rounding);
  EXPECT_NEAR(step.begin_weight(1) / (h / 2), 1.0, rounding);
  EXPECT_NEAR(step.end_weight(1) / (h / 2), 1.0, rounding);
}

TEST(FirstOrderHold, EqualsAFineRungeKutta) {
  const Eigen::Matrix3d A{{-1, 2, 0}, {-3, -0.5, 1}, {0.4, -2, -2}};
  const Eigen::Matrix<double, 3, 2> B{{1, 0}, {0, -2}, {0.5, 3}};
  const Eigen::Vector3d x0{1, -2, 0.5};
  const Eigen::Vector2d u0{1, 2}, u1{-3, 0.7};
  const auto step = first_order_hold(A, B, 0.8);
  const Eigen::VectorXd x1 = step.transition * x0 + step.begin_weight * u0 + step.end_weight * u1;
  // 4000 steps of order 4: truncation (0.8/4000)^4 ~ 2e-15; found 6.5e-15, the rounding of the steps
  EXPECT_LT((x1 - runge_kutta(A, B, x0, u0, u1, 0.8, 4000)).norm(), 7e-14);
}

TEST(FirstOrderHold, OscillatorInPhysicalUnitsKeepsItsDigits) {
  const double w = 2 * M_PI * 2000.0, h = 1e-3;  // unbalanced norm w^2 h = 1.6e5, a loss of five digits
  const Eigen::Matrix2d A{{0, 1}, {-w * w, 0}};
  const Eigen::Vector2d B{0, 1e6};
  const auto step = first_order_hold(A, B, h);
  const double rounding = 2e-14;  // of the squarings that an angle of 12.6 needs; found 1.1e-15
  EXPECT_NEAR(step.transition(0, 0), std::cos(w * h), rounding);
  EXPECT_NEAR(step.transition(1, 0) / w, -std::sin(w * h), rounding);
  // a constant input c moves the rest position to c / w^2
  const Eigen::Vector2d constant = step.begin_weight + step.end_weight;
  EXPECT_NEAR(constant(0) * w * w / 1e6, 1.0 - std::cos(w * h), rounding);
}

TEST(FirstOrderHold, StiffDecayFollowsTheInput) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Constant(1, 1, -1e9);
  const Eigen::MatrixXd B = Eigen::MatrixXd::Constant(1, 1, 1e9);
  const auto step = first_order_hold(A, B, 1e-2);
  EXPECT_EQ(step.transition(0, 0), 0.0);  // exp(-1e7) is below the smallest number
  // 1 - 1/(a h) and 1/(a h), a h = 1e7; 21 squarings: 2^21 roundings, found 2.3e-10 and 6e-10
  EXPECT_NEAR(step.end_weight(0, 0), 1.0 - 1e-7, 1e-9);
  EXPECT_NEAR(step.begin_weight(0, 0) / 1e-7, 1.0, 3e-9);
}

TEST(FirstOrderHold, RefusesWhatIsNotANumber) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  const Eigen::MatrixXd nan = one * std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(first_order_hold(nan, one, 1.0), InvalidInput);
  EXPECT_THROW(first_order_hold(one, one, 0.0), InvalidInput);
  EXPECT_THROW(first_order_hold(one, one, std::nan("")), InvalidInput);
  EXPECT_THROW(first_order_hold(one, Eigen::MatrixXd::Ones(2, 1), 1.0), InvalidInput);
}

}  // namespace
}  // namespace kalfem
