// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/argument_factor.hpp"

#include <gtest/gtest.h>

#include "kalfem/estimation/partially_linear/argument_transform.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Covariance of eight arguments of three variables, one argument without variance.
MatrixXd dependent_covariance() {
  std::srand(7);
  MatrixXd of_variables = MatrixXd::Random(8, 3);
  of_variables.row(4).setZero();
  return of_variables * of_variables.transpose();
}

TEST(IndependentArguments, AreAsManyAsTheVariablesBehindThem) {
  const MatrixXd covariance = dependent_covariance();
  MatrixXd factor;
  std::vector<Index> independent;
  ASSERT_TRUE(independent_argument_factor(covariance, Dependent::left_out, factor, independent));
  EXPECT_EQ(independent, (std::vector<Index>{0, 1, 2}));
  EXPECT_TRUE(factor.rightCols(5).isZero(0.0));
  EXPECT_TRUE((factor * factor.transpose()).isApprox(covariance, 1e-12));
}

TEST(IndependentArguments, SolveForTheSameCombinationsOfTheColumns) {
  const MatrixXd covariance = dependent_covariance(), b = MatrixXd::Random(8, 2);
  MatrixXd factor, solution;
  std::vector<Index> independent;
  ASSERT_TRUE(independent_argument_factor(covariance, Dependent::left_out, factor, independent));
  solve_independent_transposed(factor, independent, b, solution);
  ASSERT_EQ(solution.rows(), 8);
  EXPECT_TRUE((covariance * solution.topRows(2).transpose()).isApprox(factor.leftCols(3) * b.topRows(3), 1e-12));
  EXPECT_TRUE(solution.rightCols(5).isZero(0.0));
  EXPECT_TRUE(solution.bottomRows(6).isZero(0.0));
}

/// Eleven arguments and nine outputs fill no whole number of registers.
TEST(IndependentArguments, MayBeAnyNumber) {
  std::srand(3);
  const MatrixXd root = MatrixXd::Random(11, 11), covariance = root * root.transpose(), b = MatrixXd::Random(11, 9);
  MatrixXd factor, lower, solution;
  std::vector<Index> independent;
  ASSERT_TRUE(independent_argument_factor(covariance, Dependent::raised, factor, independent));
  ASSERT_TRUE(argument_factor(covariance, lower));
  ASSERT_EQ(independent.size(), 11);
  ASSERT_EQ(factor.rows(), 16);
  EXPECT_TRUE(factor.topRows(11).isApprox(lower, 1e-12));
  EXPECT_TRUE(factor.bottomRows(5).isZero(0.0));
  solve_independent_transposed(factor, independent, b, solution);
  ASSERT_EQ(solution.rows(), 16);
  EXPECT_TRUE((covariance * solution.topRows(9).transpose()).isApprox(lower * b, 1e-9));
  EXPECT_TRUE(solution.bottomRows(7).isZero(0.0));
}

/// A covariance beyond what its two variances allow is rounding: the first argument spreads alone.
TEST(IndependentArguments, DoNotFollowAnImpossibleCovariance) {
  MatrixXd factor, covariance = MatrixXd::Identity(3, 3);
  covariance(2, 0) = 1.1;
  std::vector<Index> independent;
  ASSERT_TRUE(independent_argument_factor(covariance, Dependent::raised, factor, independent));
  EXPECT_TRUE(factor.topRows(3).isIdentity(0.0));
}

TEST(IndependentArguments, RefuseWhatIsNoCovariance) {
  MatrixXd factor, covariance = dependent_covariance();
  std::vector<Index> independent;
  covariance(3, 3) = -1.0;
  EXPECT_FALSE(independent_argument_factor(covariance, Dependent::left_out, factor, independent));
  covariance(3, 3) = std::nan("");
  EXPECT_FALSE(independent_argument_factor(covariance, Dependent::left_out, factor, independent));
}

/// phi = squares and a product of the arguments.
class Squares final : public PartiallyLinearMap {
public:
  Squares() {
    gain_ = MatrixXd::Identity(3, 3);
    selection_ = MatrixXd::Zero(8, 3);
  }
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override {
    out.col(0) = in.col(0).square();
    out.col(1) = in.col(3) * in.col(5);
    out.col(2) = in.col(7).cube();
    return true;
  }
};

/// Points that would stand at the centre change no moment, whatever the spread.
TEST(IndependentArguments, GiveTheMomentsOfAllPoints) {
  MatrixXd factor;
  std::vector<Index> independent;
  ASSERT_TRUE(independent_argument_factor(dependent_covariance(), Dependent::left_out, factor, independent));
  const VectorXd centre = VectorXd::Random(8);
  for (const std::optional<double> kappa : {std::optional<double>(), std::optional<double>(1.5)}) {
    const UnscentedOptions options{.kappa = kappa, .points = SigmaPoints::of_arguments};
    Squares map;
    ArgumentTransform all(options), few(options);
    ASSERT_TRUE(all.apply(map, centre, factor));
    ASSERT_TRUE(few.apply(map, centre, factor.leftCols(3), 8));
    EXPECT_TRUE(few.mean().isApprox(all.mean(), 1e-12));
    EXPECT_TRUE(few.scatter().isApprox(all.scatter(), 1e-10));
    EXPECT_TRUE(few.delta().isApprox(all.delta().topRows(3), 1e-12));
  }
}

}  // namespace
}  // namespace kalfem
