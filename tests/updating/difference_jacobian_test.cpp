// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/difference_jacobian.hpp"

#include <gtest/gtest.h>
#include <cmath>

#include "kalfem/updating/gauss_newton.hpp"
#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nist::vector;

std::vector<UpdatingParameter> four_parameters() {
  auto parameters = free_parameters(vector({1.0, 2.0, 3.0, 4.0}));
  parameters[1].lower = 2.0;                        // one side only
  parameters[2].upper = 3.0 + 1e-6;                 // hardly any room above
  parameters[3].lower = parameters[3].upper = 4.0;  // held
  return parameters;
}

/// r_i = theta_i^2 + theta_{i+1}: differences of second order are exact but for rounding.
VectorXd squares(const VectorXd& theta) {
  VectorXd values = theta.array().square();
  values.head(3) += theta.tail(3);
  return values;
}

TEST(DifferenceJacobian, IsExactForSquaresInsideAndAtBounds) {
  const auto parameters = four_parameters();
  const VectorXd theta = initial_values(parameters);
  bool outside = false;
  const auto jacobian = difference_jacobian(parameters, theta, squares(theta), 1e-4, 1,
                                            [&](const VectorXd& beside) -> std::optional<VectorXd> {
                                              outside = outside || beside[1] < 2.0 || beside[2] > 3.0 + 1e-6;
                                              return squares(beside);
                                            });
  ASSERT_TRUE(jacobian);
  EXPECT_FALSE(outside);
  MatrixXd exact = MatrixXd((2.0 * theta).asDiagonal());
  exact.diagonal(1).setOnes();
  exact.col(3).setZero();
  EXPECT_LT((*jacobian - exact).cwiseAbs().maxCoeff(), 1e-10);  // rounding over the step: found 1e-11
}

TEST(DifferenceJacobian, IsNothingWhereAPointBesideHasNoValue) {
  const auto parameters = four_parameters();
  const VectorXd theta = initial_values(parameters);
  EXPECT_FALSE(difference_jacobian(parameters, theta, squares(theta), 1e-4, 2,
                                   [&](const VectorXd& beside) -> std::optional<VectorXd> {
                                     if (beside[0] > theta[0]) return std::nullopt;
                                     return squares(beside);
                                   }));
}

/// Free vibration of a mass on a spring after a blow, theta = [k; c; m], 30 periods. The record holds another mode that
/// the model does not have.
VectorXd ringing(const VectorXd& theta) {
  const double omega = std::sqrt(theta[0] / theta[2]), decay = 0.5 * theta[1] / theta[2];
  VectorXd values(2000);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double t = 0.1 * static_cast<double>(i), record = std::exp(-0.01 * t) * std::sin(t) + std::sin(1.3 * t + 1.0);
    values[i] = 100.0 * (std::exp(-decay * t) * std::sin(omega * t) / (theta[2] * omega) - record);
  }
  return values;
}

Termination end_of_search(bool central) {
  auto parameters = free_parameters(vector({1.01, 0.03, 0.98}));
  for (auto& each : parameters) each.lower = 0.0;
  const FunctionResidual residual(2000, [&](const VectorXd& theta) -> std::optional<ResidualValue> {
    const auto beside = [](const VectorXd& point) { return std::optional(ringing(point)); };
    ResidualValue value{ringing(theta), MatrixXd(2000, 3)};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double step = 1e-4 * parameters[static_cast<std::size_t>(i)].scale();
      value.jacobian.col(i) = (ringing(theta + step * VectorXd::Unit(3, i)) - value.values) / step;
    }
    if (central) value.jacobian = *difference_jacobian(parameters, theta, value.values, 1e-4, 1, beside);
    return value;
  });
  return minimise(residual, parameters, {.search = {.max_evaluations = 200}}).termination;
}

TEST(DifferenceJacobian, LeadsToAMinimumWithALargeResidualWhereOneSidedDifferencesStall) {
  EXPECT_EQ(end_of_search(false), Termination::no_progress);
  EXPECT_TRUE(converged(end_of_search(true))) << explain(end_of_search(true));
}

}  // namespace
}  // namespace kalfem
