// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/global_search.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;
using nist::vector;

/// 2 F = (x^2 - 1)^2 + 0.04 (x - 1)^2 / 4: minima at 1, of cost zero, and near -1.
FunctionResidual two_wells() {
  return {2, [](const VectorXd& x) {
            ResidualValue value{VectorXd(2), Eigen::MatrixXd(2, 1)};
            value.values << x[0] * x[0] - 1.0, 0.1 * (x[0] - 1.0);
            value.jacobian << 2.0 * x[0], 0.1;
            return value;
          }};
}

std::vector<UpdatingParameter> from_the_wrong_side() {
  auto parameters = free_parameters(vector({-1.5}));
  parameters[0].lower = -3.0, parameters[0].upper = 3.0;
  return parameters;
}

/// Searches that end only where nothing changes but roundings.
LeastSquaresOptions to_rounding() {
  return {.search = {.step_tolerance = 1e-12, .cost_tolerance = 0.0, .gradient_tolerance = 1e-14}};
}

TEST(MultiStart, FindsBothWellsAndHowManySearchesReachedThem) {
  const double other = -0.5 * (1.0 + std::sqrt(0.98));  // of 2 x^2 + 2 x + 0.01 = 0, the slope over x - 1
  // A search ends when its step is below 1e-6 or its gain below 1e-8 of the cost.
  EXPECT_NEAR(minimise(two_wells(), from_the_wrong_side()).parameters[0], other, 1e-6);
  const auto outcome = minimise_from_many(two_wells(), from_the_wrong_side(), {.starts = 9, .search = to_rounding()});
  EXPECT_NEAR(outcome.best.parameters[0], 1.0, 1e-13);
  ASSERT_EQ(outcome.minima.size(), 2U);
  EXPECT_LT(outcome.minima[0].cost, outcome.minima[1].cost);
  EXPECT_NEAR(outcome.minima[0].parameters[0], 1.0, 1e-13);
  // The gradient there is the difference of two terms of size one: roundings of 1e-16 over a curvature of one.
  EXPECT_NEAR(outcome.minima[1].parameters[0], other, 1e-8);
  EXPECT_EQ(outcome.minima[0].reached + outcome.minima[1].reached, outcome.converged);
  EXPECT_EQ(outcome.converged, 9);
  EXPECT_GE(outcome.minima[0].reached, 3);
  EXPECT_GE(outcome.minima[1].reached, 3);
}

TEST(MultiStart, OutcomeDoesNotDependOnThreads) {
  const auto one = minimise_from_many(two_wells(), from_the_wrong_side(), {.starts = 11, .seed = 5});
  const auto three = minimise_from_many(two_wells(), from_the_wrong_side(), {.starts = 11, .seed = 5, .threads = 3});
  EXPECT_EQ(one.best.parameters, three.best.parameters);
  EXPECT_EQ(one.evaluations, three.evaluations);
  ASSERT_EQ(one.minima.size(), three.minima.size());
  for (std::size_t i = 0; i < one.minima.size(); ++i) EXPECT_EQ(one.minima[i].reached, three.minima[i].reached);
}

TEST(MultiStart, StartsFillTheBoundsEvenly) {
  auto parameters = free_parameters(vector({10.0, 2.0, -4.0}));
  parameters[0].lower = 0.0, parameters[0].upper = 100.0;
  parameters[1].deviation = 0.5;  // 1 ... 3
  parameters[2].upper = -3.5;     // -6 ... -3.5
  const auto starts = spread_starts(parameters, 31, 1);
  ASSERT_EQ(starts.size(), 31U);
  EXPECT_EQ(starts[0], initial_values(parameters));
  const VectorXd lower = vector({0.0, 1.0, -6.0}), width = vector({100.0, 2.0, 2.5});
  const std::size_t bases[] = {2, 3, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t first = 1; first + bases[i] <= starts.size(); first += bases[i]) {
      std::set<int> strips;
      for (std::size_t k = first; k < first + bases[i]; ++k)
        strips.insert(
            static_cast<int>(std::floor((starts[k][row] - lower[row]) / width[row] * static_cast<double>(bases[i]))));
      EXPECT_EQ(strips.size(), bases[i]);
      EXPECT_EQ(*strips.begin(), 0);
    }
  }
  EXPECT_NE(starts[1], spread_starts(parameters, 31, 2)[1]);
  EXPECT_EQ(spread_starts(parameters, 1, 1).size(), 1U);
}

TEST(MultiStart, MoreStartsAreTheSameOnesAndOthers) {
  auto parameters = free_parameters(vector({10.0, 2.0}));
  const auto few = spread_starts(parameters, 4, 1), many = spread_starts(parameters, 40, 1);
  for (std::size_t k = 0; k < few.size(); ++k) EXPECT_EQ(few[k], many[k]) << k;
}

/// Cost of a search that steps over many wells, so that the best end depends on the start.
FunctionResidual many_wells() {
  return {2, [](const VectorXd& x) {
            ResidualValue value{VectorXd(2), Eigen::MatrixXd(2, 1)};
            value.values << 1.5 + std::sin(9.0 * x[0]), 0.3 * (x[0] - 1.2);
            value.jacobian << 9.0 * std::cos(9.0 * x[0]), 0.3;
            return value;
          }};
}

TEST(MultiStart, MoreStartsNeverMakeItWorse) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    double before = std::numeric_limits<double>::infinity();
    for (int starts = 1; starts <= 24; ++starts) {
      const auto outcome = minimise_from_many(many_wells(), from_the_wrong_side(), {.starts = starts, .seed = seed});
      EXPECT_LE(outcome.best.cost_final, before) << starts;
      before = outcome.best.cost_final;
    }
  }
}

/// The well at 1 is long and flat, so that a search there ends with its budget; the other converges at once.
TEST(MultiStart, TheLowestCostWinsWhateverEndedIt) {
  const FunctionResidual slow_and_low(2, [](const VectorXd& x) {
    ResidualValue value{VectorXd(2), Eigen::MatrixXd(2, 1)};
    const double right = x[0] > 0.0 ? 1.0 : 0.0;
    value.values << (right > 0.0 ? 1e-2 * std::pow(x[0] - 1.0, 3) : x[0] + 1.0), 1.0 - 0.9 * right;
    value.jacobian << (right > 0.0 ? 3e-2 * std::pow(x[0] - 1.0, 2) : 1.0), 0.0;
    return value;
  });
  MultiStartOptions options{.starts = 9, .search = {}};
  options.search.search = {
      .max_evaluations = 4, .step_tolerance = 1e-12, .cost_tolerance = 0.0, .gradient_tolerance = 0.0};
  const auto outcome = minimise_from_many(slow_and_low, from_the_wrong_side(), options);
  EXPECT_GT(outcome.converged, 0);
  EXPECT_EQ(outcome.best.termination, Termination::budget);
  EXPECT_GT(outcome.best.parameters[0], 0.0);
  ASSERT_GE(outcome.minima.size(), 2U);
  EXPECT_FALSE(outcome.minima.front().converged);
  EXPECT_EQ(outcome.minima.front().cost, outcome.best.cost_final);
  EXPECT_TRUE(outcome.minima.back().converged);
  EXPECT_NEAR(outcome.minima.back().parameters[0], -1.0, 1e-9);
  int reached = 0;
  for (const auto& minimum : outcome.minima) reached += minimum.reached;
  EXPECT_EQ(reached, 9);
}

/// Without the smoothed form the search from the initial value sticks in a well beside it.
TEST(MultiStart, EverySearchGoesThroughTheContinuation) {
  const FunctionResidual smooth(1, [](const VectorXd& x) {
    return ResidualValue{vector({x[0] - 1.2}), Eigen::MatrixXd::Ones(1, 1)};
  });
  MultiStartOptions options{.starts = 1};
  const double without = minimise_from_many(many_wells(), from_the_wrong_side(), options).best.cost_final;
  options.continuation = {&smooth};
  EXPECT_LT(minimise_from_many(many_wells(), from_the_wrong_side(), options).best.cost_final, without);
}

TEST(MultiStart, ReachesTheCertifiedPeakFromItsHardStart) {
  const auto problem = nist::eckerle4();
  auto parameters = free_parameters(problem.starts[0]);
  for (auto& p : parameters) p.lower = 0.5 * p.initial, p.upper = 2.0 * p.initial;
  parameters[1].lower = 1.0;
  const auto outcome = minimise_from_many(problem.residual, parameters, {.starts = 30, .search = to_rounding()});
  EXPECT_LT((outcome.best.parameters - problem.certified).cwiseQuotient(problem.certified).norm(), 1e-9);
}

TEST(MultiStart, ThrowsWhatASearchThrowsAndRanksNoResponseLast) {
  const FunctionResidual bad(1, [](const VectorXd& x) -> std::optional<ResidualValue> {
    if (x[0] > 0.0) throw InvalidInput("the mass is negative", "", "");
    return ResidualValue{vector({x[0] + 1.0}), Eigen::MatrixXd::Ones(1, 1)};
  });
  EXPECT_THROW((void)minimise_from_many(bad, from_the_wrong_side(), {.threads = 2}), InvalidInput);

  const FunctionResidual half(1, [](const VectorXd& x) -> std::optional<ResidualValue> {
    if (x[0] < 0.0) return std::nullopt;
    return ResidualValue{vector({x[0] - 2.0}), Eigen::MatrixXd::Ones(1, 1)};
  });
  const auto outcome = minimise_from_many(half, from_the_wrong_side());
  EXPECT_NEAR(outcome.best.parameters[0], 2.0, 1e-12);  // rounding: linear
  EXPECT_LT(outcome.converged, 8);
}

}  // namespace
}  // namespace kalfem
