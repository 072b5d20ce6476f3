#include "kalfem/updating/global_search.hpp"

#include <gtest/gtest.h>
#include <cmath>
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

TEST(MultiStart, FindsBothWellsAndHowManySearchesReachedThem) {
  const double other = -0.5 * (1.0 + std::sqrt(0.98));  // of 2 x^2 + 2 x + 0.01 = 0, the slope over x - 1
  // A search ends when its step is below 1e-6 or its gain below 1e-8 of the cost.
  EXPECT_NEAR(minimise(two_wells(), from_the_wrong_side()).parameters[0], other, 1e-6);
  const auto outcome = minimise_from_many(two_wells(), from_the_wrong_side(), {.starts = 9});
  // the last step to a residual of zero squares the error: found 1e-11
  EXPECT_NEAR(outcome.best.parameters[0], 1.0, 1e-10);
  ASSERT_EQ(outcome.minima.size(), 2U);
  EXPECT_LT(outcome.minima[0].cost, outcome.minima[1].cost);
  EXPECT_NEAR(outcome.minima[0].parameters[0], 1.0, 1e-10);
  EXPECT_NEAR(outcome.minima[1].parameters[0], other, 1e-6);
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

TEST(MultiStart, StartsAreALatinHypercube) {
  auto parameters = free_parameters(vector({10.0, 2.0, -4.0}));
  parameters[0].lower = 0.0, parameters[0].upper = 100.0;
  parameters[1].deviation = 0.5;  // 1 ... 3
  parameters[2].upper = -3.5;     // -6 ... -3.5
  const auto starts = spread_starts(parameters, 21, 1);
  ASSERT_EQ(starts.size(), 21U);
  EXPECT_EQ(starts[0], initial_values(parameters));
  const VectorXd lower = vector({0.0, 1.0, -6.0}), width = vector({100.0, 2.0, 2.5});
  for (Eigen::Index i = 0; i < 3; ++i) {
    std::set<int> strips;
    for (std::size_t k = 1; k < starts.size(); ++k)
      strips.insert(static_cast<int>(std::floor((starts[k][i] - lower[i]) / width[i] * 20.0)));
    EXPECT_EQ(strips.size(), 20U);
    EXPECT_EQ(*strips.begin(), 0);
    EXPECT_EQ(*strips.rbegin(), 19);
  }
  EXPECT_NE(starts[1], spread_starts(parameters, 21, 2)[1]);
  EXPECT_EQ(spread_starts(parameters, 1, 1).size(), 1U);
}

TEST(MultiStart, ReachesTheCertifiedPeakFromItsHardStart) {
  const auto problem = nist::eckerle4();
  auto parameters = free_parameters(problem.starts[0]);
  for (auto& p : parameters) p.lower = 0.5 * p.initial, p.upper = 2.0 * p.initial;
  parameters[1].lower = 1.0;
  const auto outcome = minimise_from_many(problem.residual, parameters, {.starts = 30});
  EXPECT_LT((outcome.best.parameters - problem.certified).cwiseQuotient(problem.certified).norm(), 5e-7);  // found 1e-7
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
