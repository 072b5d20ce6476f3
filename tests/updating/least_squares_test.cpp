// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/gauss_newton.hpp"

#include <gtest/gtest.h>

#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nist::vector;

GaussNewtonOptions sharp() {
  return {.max_evaluations = 500, .step_tolerance = 1e-9, .cost_tolerance = 1e-14, .gradient_tolerance = 1e-12};
}

/// Certified values of the statistical reference datasets, from both starting points of each. Eleven digits are given;
/// a cost that is flat at its minimum leaves sqrt(rounding) of them, times the condition of the problem. From
/// its first start the peak of Eckerle4 is out of sight of a local search.
TEST(LeastSquares, ReachesCertifiedRegressions) {
  for (const auto& problem : nist_problems())
    for (std::size_t start = problem.name == "Eckerle4" ? 1 : 0; start < 2; ++start) {
      const bool flat = problem.name == "MGH09" || problem.name == "Thurber";  // found 5e-7, and 5e-9 for the others
      SCOPED_TRACE(problem.name + " from start " + std::to_string(start + 1));
      const auto outcome = minimise(problem.residual, free_parameters(problem.starts[start]), {.search = sharp()});
      EXPECT_TRUE(outcome.usable()) << outcome.reason();
      // eleven digits are given: found 4e-11
      EXPECT_NEAR(2.0 * outcome.cost_final, problem.sum_of_squares, 1e-10 * problem.sum_of_squares);
      EXPECT_LT((outcome.parameters - problem.certified).cwiseQuotient(problem.certified).cwiseAbs().maxCoeff(),
                flat ? 1e-6 : 1e-8);
      EXPECT_LT(outcome.evaluations, start == 0 ? 300 : 60);
    }
}

TEST(LeastSquares, StandardTolerancesEndWithinASmallPartOfTheDeviations) {
  for (const auto& problem : nist_problems()) {
    SCOPED_TRACE(problem.name);
    const auto outcome = minimise(problem.residual, free_parameters(problem.starts[1]));
    EXPECT_TRUE(outcome.usable()) << outcome.reason();
    const VectorXd error = (outcome.parameters - problem.certified).cwiseQuotient(problem.certified_deviations);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 5e-4);  // found 2e-4
    EXPECT_LT(outcome.evaluations, 40);
  }
}

TEST(LeastSquares, FollowsRosenbrocksValley) {
  auto search = sharp();
  search.step_tolerance = 1e-13;
  const auto outcome = minimise(rosenbrock(), free_parameters(vector({-1.2, 1.0})), {.search = search});
  EXPECT_TRUE(outcome.usable());
  // the last step to a residual of zero squares the error: only roundings are left
  EXPECT_NEAR(outcome.parameters[0], 1.0, 1e-12);
  EXPECT_NEAR(outcome.parameters[1], 1.0, 1e-12);
  EXPECT_LT(outcome.evaluations, 60);
}

TEST(LeastSquares, FindsTheMinimumOnABound) {
  auto parameters = free_parameters(vector({-1.2, 1.0}));
  parameters[0].upper = 0.5;
  const auto on_x = minimise(rosenbrock(), parameters, {.search = sharp()});
  EXPECT_TRUE(on_x.usable()) << on_x.reason();
  EXPECT_EQ(on_x.parameters[0], 0.5);
  EXPECT_NEAR(on_x.parameters[1], 0.25, 1e-14);  // rounding: linear on the bound
  EXPECT_NEAR(on_x.cost_final, 0.125, 1e-15);

  parameters = free_parameters(vector({-1.2, -0.5}));
  parameters[1].upper = 0.5;
  const auto on_y = minimise(rosenbrock(), parameters, {.search = sharp()});
  EXPECT_TRUE(on_y.usable()) << on_y.reason();
  EXPECT_EQ(on_y.parameters[1], 0.5);
  const double x = on_y.parameters[0];
  // a cost tolerance of 1e-14 leaves sqrt(2e-14 F / F") = 2e-9 of x, which 2 F" = 400 makes 1e-6
  EXPECT_NEAR(-400.0 * x * (0.5 - x * x) - 2.0 * (1.0 - x), 0.0, 3e-6) << "stationary along the bound";

  parameters[0].lower = parameters[0].upper = -1.2;
  const auto held = minimise(rosenbrock(), parameters, {.search = sharp()});
  EXPECT_EQ(held.parameters, vector({-1.2, 0.5})) << "equal bounds hold a parameter, the other goes to its bound";
}

TEST(LeastSquares, RecordsItsCourse) {
  std::vector<int> seen;
  LeastSquaresOptions options;
  options.watch = [&](const LeastSquaresIteration& iteration) { return seen.push_back(iteration.evaluation), true; };
  auto parameters = free_parameters(vector({-1.2, 1.0}));
  parameters[0].deviation = 100.0;
  const auto outcome = minimise(rosenbrock(), parameters, options);
  ASSERT_EQ(static_cast<int>(outcome.trace.size()), outcome.evaluations);
  EXPECT_EQ(seen.size(), outcome.trace.size());
  EXPECT_EQ(outcome.trace.front().cost, outcome.cost_initial);
  EXPECT_EQ(outcome.trace.back().cost, outcome.cost_final);
  EXPECT_EQ(outcome.cost_initial, outcome.residual_cost_initial);
  EXPECT_NEAR(outcome.residual_cost_initial, 12.1, 5e-14);  // rounding
  EXPECT_GT(outcome.cost_final, outcome.residual_cost_final);
  int accepted = 0;
  for (std::size_t i = 1; i < outcome.trace.size(); ++i) {
    EXPECT_LE(outcome.trace[i].cost, outcome.trace[i - 1].cost);
    EXPECT_EQ(outcome.trace[i].accepted, outcome.trace[i].cost < outcome.trace[i - 1].cost);
    accepted += outcome.trace[i].accepted ? 1 : 0;
  }
  EXPECT_EQ(accepted, outcome.iterations);
  const auto there = rosenbrock().evaluate(outcome.parameters, true);
  EXPECT_EQ(outcome.residual.values, there->values);
  EXPECT_EQ(outcome.residual.jacobian, there->jacobian);
}

TEST(LeastSquares, StopsOnRequestWithTheJacobianOfItsLastPoint) {
  LeastSquaresOptions options;
  for (int last = 1; last < 12; ++last) {
    options.watch = [&](const LeastSquaresIteration& iteration) { return iteration.evaluation < last; };
    const auto outcome = minimise(rosenbrock(), free_parameters(vector({-1.2, 1.0})), options);
    EXPECT_EQ(outcome.termination, Termination::stopped);
    EXPECT_EQ(outcome.residual.jacobian, rosenbrock().evaluate(outcome.parameters, true)->jacobian);
    EXPECT_EQ(static_cast<int>(outcome.trace.size()), last);
  }
}

TEST(LeastSquares, HasTheJacobianOfAPointTriedWithoutIt) {
  const FunctionResidual residual(1, [](const VectorXd& theta) -> std::optional<ResidualValue> {
    if (theta[0] < 0.6) return std::nullopt;  // two steps in turn are too long: the third goes without a Jacobian
    return ResidualValue{vector({theta[0] + 0.8}), MatrixXd::Ones(1, 1)};
  });
  LeastSquaresOptions options;
  options.search.initial_radius = 10.0;
  options.watch = [&](const LeastSquaresIteration& iteration) { return iteration.evaluation < 4; };
  const auto outcome = minimise(residual, free_parameters(vector({1.0})), options);
  EXPECT_EQ(outcome.trace.size(), 4U);
  EXPECT_EQ(outcome.evaluations, 5);
  EXPECT_LT(outcome.parameters[0], 1.0);
  EXPECT_EQ(outcome.residual.jacobian.size(), 1);
}

TEST(LeastSquares, SaysThatTheModelHasNoResponseAtTheStart) {
  const FunctionResidual never(3, [](const VectorXd&) { return std::nullopt; });
  const auto outcome = minimise(never, free_parameters(vector({1.0})));
  EXPECT_FALSE(outcome.usable());
  EXPECT_EQ(outcome.termination, Termination::no_response);
  EXPECT_EQ(outcome.evaluations, 1);
  EXPECT_EQ(outcome.residual.values.size(), 0);
}

TEST(LeastSquares, AStartOfItsOwnLeavesThePriorWhereItIs) {
  auto parameters = free_parameters(vector({1.0}));
  parameters[0].deviation = 1.0;
  const auto residual = linear_residual(MatrixXd::Ones(1, 1), vector({3.0}));
  const auto outcome = minimise(residual, parameters, {.start = vector({5.0})});
  EXPECT_NEAR(outcome.parameters[0], 2.0, 1e-14);  // rounding
  EXPECT_NEAR(outcome.cost_initial, 0.5 * 4.0 + 0.5 * 16.0, 1e-14);
}

}  // namespace
}  // namespace kalfem
