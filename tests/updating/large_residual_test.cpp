// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "kalfem/updating/gauss_newton.hpp"
#include "updating/nist_problems.hpp"

// Searches that end with a large residual, because no parameters explain the measurement.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nist::vector;

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr Index samples = 400;

/// exp(-z 2 pi f t) sin(2 pi f t)
double tone(double frequency, double ratio, double time) {
  return std::exp(-ratio * two_pi * frequency * time) * std::sin(two_pi * frequency * time);
}

/// theta = [frequency; damping ratio] of one decaying tone against a record of two, of 1 Hz and 2.8 Hz. As with a
/// simulated response, the frequency acts on the phase and is felt a hundred times more than the damping.
FunctionResidual one_tone_for_two() {
  return {samples, [](const VectorXd& theta) -> std::optional<ResidualValue> {
            constexpr double noise = 0.01;
            ResidualValue value{VectorXd(samples), MatrixXd(samples, 2)};
            for (Index k = 0; k < samples; ++k) {
              const double time = 0.05 * static_cast<double>(k), angle = two_pi * theta[0] * time;
              const double decay = std::exp(-theta[1] * angle);
              value.values[k] =
                  (tone(theta[0], theta[1], time) - tone(1.0, 0.01, time) - 0.6 * tone(2.8, 0.01, time)) / noise;
              value.jacobian(k, 0) = two_pi * time * decay * (std::cos(angle) - theta[1] * std::sin(angle)) / noise;
              value.jacobian(k, 1) = -angle * decay * std::sin(angle) / noise;
            }
            return value;
          }};
}

/// One box for both parameters, and no second-order part, took 250 to 1000 evaluations from these starts.
TEST(LargeResidual, ATooSimpleModelConvergesFromSeveralStarts) {
  for (const double frequency : {0.95, 0.98, 1.03, 1.06})
    for (const double ratio : {0.002, 0.03}) {
      auto parameters = free_parameters(vector({frequency, ratio}));
      parameters[0].lower = 0.5, parameters[1].lower = 0.0;
      const auto outcome = minimise(one_tone_for_two(), parameters);
      EXPECT_TRUE(outcome.usable()) << outcome.reason();
      EXPECT_NEAR(outcome.parameters[0], 1.0, 1e-4);
      EXPECT_NEAR(outcome.parameters[1], 0.01, 1e-4);
      EXPECT_LE(outcome.evaluations, 20) << frequency << ' ' << ratio;  // found 7 to 16
    }
}

/// r = [x - 1; y - 1; 3 + c (x^2 + y^2) / 2]: at the minimum the second-order part 3 c is `c` times J^T J or more.
FunctionResidual bowl(double curvature) {
  return {3, [curvature](const VectorXd& x) {
            ResidualValue value{VectorXd(3), MatrixXd(3, 2)};
            value.values << x[0] - 1.0, x[1] - 1.0, 3.0 + 0.5 * curvature * x.squaredNorm();
            value.jacobian << 1.0, 0.0, 0.0, 1.0, curvature * x[0], curvature * x[1];
            return value;
          }};
}

/// Gauss-Newton steps overshoot by the ratio of S to J^T J and then alternate.
TEST(LargeResidual, TheSecondOrderPartMakesConvergenceFast) {
  for (const double curvature : {0.3, 1.0, 3.0}) {
    const auto outcome = minimise(bowl(curvature), free_parameters(vector({1.0, 0.7})),
                                  {.search = {.step_tolerance = 1e-9, .cost_tolerance = 0.0}});
    EXPECT_TRUE(outcome.usable()) << outcome.reason();
    const VectorXd gradient = outcome.residual.jacobian.transpose() * outcome.residual.values;
    EXPECT_LT(gradient.norm(), 1e-6);  // of columns and a residual of about 3
    EXPECT_LE(outcome.evaluations, 20) << curvature;
  }
}

TEST(LargeResidual, TheSecantIsExactAlongTheStepAndSymmetric) {
  const SecantEnd begin{MatrixXd{{2.0, 0.3}, {0.0, 1.0}}, vector({1.0, -2.0})};
  const SecantEnd end{MatrixXd{{1.8, 0.1}, {0.0, 1.2}}, vector({2.5, -1.0})};
  const VectorXd step = vector({0.3, 0.4});
  const MatrixXd before{{0.5, 0.2}, {0.2, -0.1}};
  const auto normal = [](const SecantEnd& at) -> MatrixXd {
    return at.jacobian_factor.transpose() * at.jacobian_factor;
  };
  const VectorXd growth = end.jacobian_factor.transpose() * end.projected_residual -
                          begin.jacobian_factor.transpose() * begin.projected_residual;
  const VectorXd wanted = growth - 0.5 * (normal(begin) + normal(end)) * step;
  for (const auto& start : {MatrixXd(), before}) {
    const MatrixXd second_order = updated_second_order(start, step, begin, end);
    EXPECT_LT((second_order * step - wanted).norm(), 1e-14);
    EXPECT_LT((second_order - second_order.transpose()).norm(), 1e-15);
  }
}

TEST(LargeResidual, TheModelWithSecondOrderPartHasGradientAndHessian) {
  const QuadraticModel model{MatrixXd{{2.0, 0.3}, {0.0, 1.0}, {0.5, 0.0}}, vector({1.0, -2.0, 0.4})};
  const MatrixXd second_order{{0.5, 0.2}, {0.2, -0.4}};
  const auto augmented = with_second_order(model, second_order);
  ASSERT_TRUE(augmented);
  EXPECT_LT((augmented->gradient() - model.gradient()).norm(), 1e-14);
  EXPECT_LT((augmented->matrix.transpose() * augmented->matrix - model.matrix.transpose() * model.matrix - second_order)
                .norm(),
            1e-14);
  EXPECT_FALSE(with_second_order(model, MatrixXd{{0.0, 0.0}, {0.0, -3.0}}));
}

}  // namespace
}  // namespace kalfem
