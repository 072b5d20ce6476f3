// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/discretisation.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Two modes, one damped and one a free body, that drive a filter.
MatrixXd dynamics() {
  MatrixXd A = MatrixXd::Zero(5, 5);
  A << 0, 1, 0, 0, 0,     //
      -900, -3, 0, 0, 0,  //
      0, 0, 0, 1, 0,      //
      0, 0, 0, 0, 0,      //
      70, 0, 0, 2, -250.0;
  return A;
}

MatrixXd gain() {
  MatrixXd B = MatrixXd::Zero(5, 2);
  B << 0, 0, 1, 2e3, 0, 0, -1, 5e2, 0, 3;
  return B;
}

constexpr double h = 0.037;
const MatrixXd begin = (MatrixXd(2, 1) << 1.0, -2.0).finished(), middle = (MatrixXd(2, 1) << 0.3, 4.0).finished(),
               end = (MatrixXd(2, 1) << -1.5, 1.0).finished();

using Course = VectorXd (*)(double share);
VectorXd quadratic(double s) {
  return (1 - s) * (1 - 2 * s) * begin + 4 * s * (1 - s) * middle - s * (1 - 2 * s) * end;
}
VectorXd halves(double s) {
  return s < 0.5 ? (1 - 2 * s) * begin + 2 * s * middle : (2 - 2 * s) * middle + (2 * s - 1) * end;
}

/// int_0^t exp(A (t - tau)) B u(tau) dtau by Gauss's rule of five points on 64 pieces.
VectorXd driven(Course course, double t) {
  constexpr int pieces = 64;
  const std::array<double, 3> at{0.0, 0.5384693101056831, 0.9061798459386640},
      weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  VectorXd sum = VectorXd::Zero(5);
  const double piece = t / pieces;
  for (int i = 0; i < pieces; ++i)
    for (int j = -2; j <= 2; ++j) {
      const auto place = std::size_t(std::abs(j));
      const double tau = (i + 0.5 + 0.5 * (j < 0 ? -at[place] : at[place])) * piece;
      sum += 0.5 * weight[place] * piece * MatrixXd(dynamics() * (t - tau)).exp() * gain() * course(tau / h);
    }
  return sum;
}

void near(const VectorXd& found, const VectorXd& expected) {
  // The rule and the exponentials are exact to rounding, found 4e-14
  EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm());
}

TEST(QuadraticHold, IsExactForAnInputThatIsQuadraticOverTheInterval) {
  const auto hold = quadratic_hold(dynamics(), gain(), h);
  const VectorXd x0 = (VectorXd(5) << 1.0, -3.0, 0.2, 5.0, 7.0).finished();
  for (const auto& [at, t] : {std::pair{hold.middle, h / 2}, std::pair{hold.end, h}})
    near(at.transition * x0 + at.begin_weight * begin + at.middle_weight * middle + at.end_weight * end,
         MatrixXd(dynamics() * t).exp() * x0 + driven(quadratic, t));
}

TEST(QuadraticHold, TellsWhatAnInputThatIsLinearOverEitherHalfLacks) {
  const auto hold = quadratic_hold(dynamics(), gain(), h);
  near(hold.curvature_weight * (begin - 2 * middle + end), driven(quadratic, h) - driven(halves, h));
}

TEST(QuadraticHold, IsTheFirstOrderHoldForStraightInputs) {
  const auto hold = quadratic_hold(dynamics(), gain(), h);
  const auto straight = first_order_hold(dynamics(), gain(), h);
  EXPECT_LT((hold.end.transition - straight.transition).norm(), 1e-13 * straight.transition.norm());
  EXPECT_LT((hold.end.begin_weight + 0.5 * hold.end.middle_weight - straight.begin_weight).norm(),
            1e-12 * straight.begin_weight.norm());
  EXPECT_LT((hold.end.end_weight + 0.5 * hold.end.middle_weight - straight.end_weight).norm(),
            1e-12 * straight.end_weight.norm());
}

TEST(QuadraticHold, RefusesWhatIsNoStep) {
  EXPECT_THROW(quadratic_hold(dynamics(), gain(), 0.0), InvalidInput);
  EXPECT_THROW(quadratic_hold(dynamics(), MatrixXd::Zero(4, 1), h), InvalidInput);
  EXPECT_EQ(quadratic_hold(MatrixXd(0, 0), MatrixXd(0, 2), h).end.begin_weight.cols(), 2);
}

}  // namespace
}  // namespace kalfem
