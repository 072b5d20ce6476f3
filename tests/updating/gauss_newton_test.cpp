// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/gauss_newton.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <random>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nist::vector;

MatrixXd random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

GaussNewtonState run(GaussNewton& search, const Residual& residual) {
  while (!search.finished()) search.tell(residual.evaluate(search.proposal(), search.needs_jacobian()));
  return search.state();
}

// ------------------------------------------------------------------------------------------- the bounded linear
// problem

/// The minimum by trying every choice of unknowns at their lower bound, at their upper one and between.
VectorXd enumerated(const MatrixXd& matrix, const VectorXd& offset, const VectorXd& lower, const VectorXd& upper) {
  const Index count = lower.size();
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (int code = 0; code < std::pow(3, count); ++code) {
    VectorXd point = VectorXd::Zero(count);
    std::vector<Index> free;
    for (Index i = 0, rest = code; i < count; ++i, rest /= 3) {
      if (rest % 3 == 0) free.push_back(i);
      if (rest % 3 == 1) point[i] = lower[i];
      if (rest % 3 == 2) point[i] = upper[i];
    }
    if (!free.empty()) {
      const MatrixXd columns = matrix(Eigen::all, free);
      point(free) = columns.householderQr().solve(-offset - matrix * point).eval();
    }
    if ((point.array() < lower.array() - 1e-12).any() || (point.array() > upper.array() + 1e-12).any()) continue;
    const double cost = (matrix * point + offset).squaredNorm();
    if (cost < least) least = cost, best = point;
  }
  return best;
}

TEST(BoundedLeastSquares, FindsTheMinimumThatEnumerationFinds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> width(0.0, 0.6);
  for (int trial = 0; trial < 300; ++trial) {
    MatrixXd matrix = random_matrix(random, 8, 4);
    matrix.col(1) += 3.0 * matrix.col(0);  // columns that act alike make the choice of bounds hard
    const VectorXd offset = random_matrix(random, 8, 1);
    const VectorXd lower = VectorXd::NullaryExpr(4, [&] { return -width(random); });
    const VectorXd upper = VectorXd::NullaryExpr(4, [&] { return trial % 5 == 0 ? 0.0 : width(random); });
    const VectorXd expected = enumerated(matrix, offset, lower, upper);
    const VectorXd found = bounded_least_squares(matrix, offset, lower, upper, 1e-10);
    // rounding, and columns that act alike
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 5e-14) << "trial " << trial;
  }
}

TEST(BoundedLeastSquares, LeavesWhatTheMatrixDoesNotDetermine) {
  std::mt19937 random(2);
  MatrixXd matrix = random_matrix(random, 10, 4);
  matrix.col(1) = 1e6 * matrix.col(0);  // only x0 + 1e6 x1 counts
  matrix.col(3).setZero();
  const VectorXd offset = random_matrix(random, 10, 1);
  const VectorXd wide = VectorXd::Constant(4, 1e3);
  const VectorXd found = bounded_least_squares(matrix, offset, -wide, wide, 1e-7);
  EXPECT_EQ(found[3], 0.0);
  // rounding
  EXPECT_NEAR(found[1] * 1e6 / found[0], 1.0, 1e-14);  // both do the same share of what they do together
  EXPECT_LT((matrix.transpose() * (matrix * found + offset)).cwiseQuotient(vector({1, 1e6, 1, 1})).norm(), 1e-14);

  const VectorXd lower = vector({-1e3, 0.1 * std::min(found[1], 0.0), -1e3, -1e3});
  const VectorXd upper = vector({1e3, 0.1 * std::max(found[1], 0.0), 1e3, 1e3});
  const VectorXd bounded = bounded_least_squares(matrix, offset, lower, upper, 1e-7);
  EXPECT_NEAR((matrix * bounded + offset).norm(), (matrix * found + offset).norm(), 1e-14)
      << "the first unknown makes up for the second, which a bound holds";
}

// -------------------------------------------------------------------------------------------------- the search

TEST(GaussNewton, LinearProblemTakesOneStepWithPriorAsInClosedForm) {
  std::mt19937 random(3);
  const MatrixXd matrix = random_matrix(random, 30, 3);
  const VectorXd right = random_matrix(random, 30, 1);
  auto parameters = free_parameters(vector({1.0, -2.0, 0.5}));
  parameters[0].deviation = 0.1;
  parameters[2].deviation = 2.0;
  GaussNewton search(parameters, {.initial_radius = 1e3});
  const auto state = run(search, linear_residual(matrix, right));

  const VectorXd precision = vector({100.0, 0.0, 0.25});
  const MatrixXd normal = matrix.transpose() * matrix + MatrixXd(precision.asDiagonal());
  const VectorXd expected =
      normal.ldlt().solve(matrix.transpose() * right + precision.cwiseProduct(initial_values(parameters)));
  EXPECT_LT((state.parameters - expected).norm(), 1e-14);  // rounding
  EXPECT_EQ(state.evaluations, 2);
  EXPECT_EQ(state.iterations, 1);
  EXPECT_TRUE(converged(*search.finished()));
  const double cost = 0.5 * (matrix * expected - right).squaredNorm() +
                      0.5 * (expected - initial_values(parameters)).cwiseAbs2().dot(precision);
  EXPECT_NEAR(search.cost(), cost, 1e-14 * cost);  // rounding
}

/// A residual that falls by less than promised does not pay for the prior that the step costs.
TEST(GaussNewton, CountsThePriorOfATrial) {
  const FunctionResidual residual(1, [](const VectorXd& theta) {
    const double bend = std::tanh(theta[0] / 0.05);
    return ResidualValue{vector({10.0 - 0.5 * bend}), MatrixXd::Constant(1, 1, -10.0 * (1.0 - bend * bend))};
  });
  auto parameters = free_parameters(vector({0.0}));
  parameters[0].deviation = 0.05;
  GaussNewton search(parameters, {});
  search.tell(residual.evaluate(search.proposal(), true));
  // The linearised step is 100 / (100 + 400): there the residual's cost is 45.1 instead of 50, and the prior's 8.
  EXPECT_NEAR(search.proposal()[0], 0.2, 1e-15);  // rounding
  EXPECT_FALSE(search.tell(residual.evaluate(search.proposal(), true)));
  EXPECT_EQ(search.state().refused, 1);
  EXPECT_EQ(search.state().parameters[0], 0.0);
  double cost = search.cost();
  for (int i = 0; i < 20 && !search.finished(); ++i) {
    search.tell(residual.evaluate(search.proposal(), search.needs_jacobian()));
    EXPECT_LE(search.cost(), cost);
    cost = search.cost();
  }
}

TEST(GaussNewton, ParametersThatNothingInformsStay) {
  // r depends on a + b only and not at all on d; c is seen well. a and b differ by nine orders of magnitude.
  const FunctionResidual residual(20, [](const VectorXd& theta) {
    ResidualValue value{VectorXd(20), MatrixXd::Zero(20, 4)};
    for (Index i = 0; i < 20; ++i) {
      const double t = 0.1 * static_cast<double>(i), a = theta[0] / 1e9, b = theta[1];
      const double decay = std::exp(-(a + b) * t), slope = -t * theta[2] * decay;
      value.values[i] = theta[2] * decay - 3.0 * std::exp(-1.7 * t);
      value.jacobian.row(i) << slope / 1e9, slope, decay, 0.0;
    }
    return value;
  });
  GaussNewton search(free_parameters(vector({1e9, 1.0, 2.0, 7.0})), {.step_tolerance = 1e-10, .cost_tolerance = 0.0});
  const auto state = run(search, residual);
  EXPECT_TRUE(converged(*search.finished())) << explain(*search.finished());
  EXPECT_EQ(state.parameters[3], 7.0);
  // the last step to a residual of zero squares the error: only roundings are left
  EXPECT_NEAR(state.parameters[0] / 1e9, 0.85, 1e-12) << "both share the change, as their scales are alike";
  EXPECT_NEAR(state.parameters[1], 0.85, 1e-12);
  EXPECT_NEAR(state.parameters[2], 3.0, 1e-12);
}

TEST(GaussNewton, ShortensStepsIntoARegionWithoutResponse) {
  // sqrt(theta) - 0.01: the first full step from 1 would lead to a negative theta.
  int refused = 0;
  const FunctionResidual residual(1, [&](const VectorXd& theta) -> std::optional<ResidualValue> {
    if (theta[0] <= 0.0) return ++refused, std::nullopt;
    return ResidualValue{vector({std::sqrt(theta[0]) - 0.1}), MatrixXd::Constant(1, 1, 0.5 / std::sqrt(theta[0]))};
  });
  GaussNewton search(free_parameters(vector({1.0})), {.initial_radius = 10.0});
  const auto state = run(search, residual);
  EXPECT_TRUE(converged(*search.finished())) << explain(*search.finished());
  EXPECT_NEAR(state.parameters[0], 0.01, 4e-9);  // found 1e-9: the last step squares an error of 6e-4 of it
  EXPECT_GT(refused, 0);
  EXPECT_EQ(state.without_response, refused);
}

TEST(GaussNewton, TakesNumbersThatAreNotFiniteAsNoResponse) {
  GaussNewton search(free_parameters(vector({1.0})), {});
  EXPECT_FALSE(search.tell(ResidualValue{vector({std::nan("")}), MatrixXd::Ones(1, 1)}));
  EXPECT_EQ(search.finished(), Termination::no_response);
}

TEST(GaussNewton, AsksForTheJacobianOfAPointTriedWithoutIt) {
  const auto residual = rosenbrock();
  GaussNewton search(free_parameters(vector({-1.2, 1.0})), {});
  search.tell(residual.evaluate(search.proposal(), true));
  const VectorXd trial = search.proposal();
  ASSERT_TRUE(search.tell(residual.evaluate(trial, false)));
  EXPECT_EQ(search.proposal(), trial);
  EXPECT_TRUE(search.needs_jacobian());
  EXPECT_TRUE(search.tell(residual.evaluate(trial, true)));
  EXPECT_NE(search.proposal(), trial);
  EXPECT_EQ(search.state().iterations, 1);
  EXPECT_EQ(search.state().evaluations, 3);
}

TEST(GaussNewton, DoesWithoutJacobiansAfterTwoFailedTrials) {
  // The full step from 1 leads to -0.8, a quarter of it to 0.55, both too far for a model that ends at 0.6.
  const FunctionResidual residual(1, [](const VectorXd& theta) -> std::optional<ResidualValue> {
    if (theta[0] < 0.6) return std::nullopt;
    return ResidualValue{vector({theta[0] + 0.8}), MatrixXd::Ones(1, 1)};
  });
  GaussNewton search(free_parameters(vector({1.0})), {.initial_radius = 10.0});
  const auto next = [&] { return search.tell(residual.evaluate(search.proposal(), search.needs_jacobian())); };
  EXPECT_TRUE(next());
  EXPECT_FALSE(next());
  EXPECT_TRUE(search.needs_jacobian());
  EXPECT_FALSE(next());
  EXPECT_FALSE(search.needs_jacobian());
  EXPECT_TRUE(next());
  EXPECT_TRUE(search.needs_jacobian());
  EXPECT_EQ(search.proposal(), search.state().parameters);
  EXPECT_TRUE(next());
  EXPECT_TRUE(search.needs_jacobian());
}

TEST(GaussNewton, AStepOntoABoundEndsExactlyThere) {
  RandomStream random(1, "bounds");
  for (int trial = 0; trial < 500; ++trial) {
    const double initial = 0.1 + random.uniform(), bound = initial * 2.0 * random.uniform();
    auto parameters = free_parameters(vector({initial}));
    (bound < initial ? parameters[0].lower : parameters[0].upper) = bound;
    GaussNewton search(parameters, {.initial_radius = 0.07});
    const auto state = run(search, linear_residual(MatrixXd::Ones(1, 1), vector({bound < initial ? -9.0 : 9.0})));
    EXPECT_EQ(state.parameters[0], bound);
    EXPECT_EQ(search.finished(), Termination::converged_gradient) << "the bound is known to hold it";
  }
}

TEST(GaussNewton, EndsWhereThereAreNoDerivatives) {
  const auto residual = rosenbrock();
  GaussNewton search(free_parameters(vector({-1.2, 1.0})), {});
  search.tell(residual.evaluate(search.proposal(), true));
  ASSERT_TRUE(search.tell(residual.evaluate(search.proposal(), false)));
  search.tell(std::nullopt);
  EXPECT_EQ(search.finished(), Termination::no_derivatives);
}

TEST(GaussNewton, CheapTrialsLeadToTheSamePoints) {
  const auto residual = rosenbrock();
  GaussNewton full(free_parameters(vector({-1.2, 1.0})), {}), cheap(free_parameters(vector({-1.2, 1.0})), {});
  while (!full.finished()) full.tell(residual.evaluate(full.proposal(), true));
  while (!cheap.finished())
    cheap.tell(residual.evaluate(cheap.proposal(), cheap.state().known != GaussNewtonState::Known::derivatives));
  EXPECT_EQ(full.state().parameters, cheap.state().parameters);
  EXPECT_EQ(full.state().iterations, cheap.state().iterations);
}

TEST(GaussNewton, ContinuesFromItsStateToTheLastBit) {
  const auto problem = nist::thurber();
  auto parameters = free_parameters(problem.starts[0]);
  parameters[0].upper = 1280.0;  // active at the end
  parameters[4].deviation = 1.0;
  const GaussNewtonOptions options{.max_evaluations = 500};
  GaussNewton whole(parameters, options), part(parameters, options);
  while (!whole.finished()) {
    ASSERT_EQ(whole.proposal(), part.proposal());
    ASSERT_EQ(whole.needs_jacobian(), part.needs_jacobian());
    const auto value = problem.residual.evaluate(whole.proposal(), whole.needs_jacobian());
    ASSERT_EQ(whole.tell(value), part.tell(value));
    part = GaussNewton(parameters, options, GaussNewtonState(part.state()));
  }
  EXPECT_EQ(whole.finished(), part.finished());
  EXPECT_EQ(whole.state().parameters[0], 1280.0);
  EXPECT_GT(whole.state().iterations, 5);
}

TEST(GaussNewton, SaysWhenDerivativesLeadNowhere) {
  const FunctionResidual wrong(2, [](const VectorXd& theta) {
    return ResidualValue{vector({theta[0] - 3.0, 1.0}), vector({-1.0, 0.0})};  // the sign is wrong
  });
  GaussNewton search(free_parameters(vector({1.0})), {});
  run(search, wrong);
  EXPECT_EQ(search.finished(), Termination::no_progress);
  EXPECT_EQ(search.state().parameters[0], 1.0);
}

TEST(GaussNewton, EndsWithItsBudget) {
  GaussNewton search(free_parameters(vector({-1.2, 1.0})), {.max_evaluations = 4});
  EXPECT_EQ(run(search, rosenbrock()).evaluations, 4);
  EXPECT_EQ(search.finished(), Termination::budget);
}

/// |theta - 3|^2 in units of its noise, rough by 1e-5 of them: derivatives lead nowhere once that is all that is left.
FunctionResidual rough() {
  return {2, [](const VectorXd& theta) {
            const double roughness = theta[0] == 2.95 ? 0.0 : 2e-3;
            return ResidualValue{vector({theta[0] - 3.0, 1.0 + roughness}), vector({1.0, 0.0})};
          }};
}

TEST(GaussNewton, ConvergesWhereItStallsATenthOfADeviationFromTheMinimum) {
  GaussNewton noisy(free_parameters(vector({2.95})), {.cost_floor = 1e-6}), plain(free_parameters(vector({2.95})), {});
  run(noisy, rough());
  run(plain, rough());
  EXPECT_EQ(noisy.finished(), Termination::converged_cost);  // the next step promises 0.05^2
  EXPECT_EQ(noisy.state().parameters[0], 2.95);
  EXPECT_LE(noisy.state().evaluations, 3);
  EXPECT_EQ(plain.finished(), Termination::no_progress);  // its units are not those of noise
}

TEST(GaussNewton, HasNotConvergedWhereItStallsFartherAway) {
  const FunctionResidual far(2, [](const VectorXd& theta) {
    return ResidualValue{vector({theta[0] - 3.0, theta[0] == 2.8 ? 1.0 : 2.0}), vector({1.0, 0.0})};
  });
  GaussNewton search(free_parameters(vector({2.8})), {.cost_floor = 1e-6});
  run(search, far);
  EXPECT_EQ(search.finished(), Termination::no_progress);  // the next step promises 0.2^2
}

TEST(GaussNewton, ConvergesWithItsBudgetUsedUpCloseToTheMinimum) {
  for (const auto& [start, end] : {std::pair(2.95, Termination::converged_cost), {2.8, Termination::budget}}) {
    GaussNewton search(free_parameters(vector({start})), {.max_evaluations = 1, .cost_floor = 1e-6});
    run(search, linear_residual(MatrixXd::Ones(1, 1), vector({3.0})));
    EXPECT_EQ(search.finished(), end) << start;
  }
}

TEST(GaussNewton, ReportsAllParametersThatItCannotBeginWith) {
  auto parameters = free_parameters(vector({1.0, 2.0, 3.0, 4.0}));
  parameters[0].lower = 2.0;
  parameters[1].lower = 3.0, parameters[1].upper = 1.0;
  parameters[2].deviation = 0.0;
  try {
    GaussNewton(parameters, {});
    FAIL() << "no error";
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.issues().size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NE(error.issues()[i].what.find(parameters[i].name), std::string::npos);
  }
}

TEST(Termination, HasWordsOfItsOwn) {
  std::set<std::string> all;
  for (int i = 0; i <= static_cast<int>(Termination::stopped); ++i) all.insert(explain(static_cast<Termination>(i)));
  EXPECT_EQ(all.size(), static_cast<std::size_t>(Termination::stopped) + 1);
  EXPECT_FALSE(all.contains(""));
}

}  // namespace
}  // namespace kalfem
