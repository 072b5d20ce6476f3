// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/lowest_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::VectorXd;

SparseMatrix<double> diagonal(const VectorXd& values) { return SparseMatrix<double>(values.asDiagonal()); }

/// Chain of unit springs; with `fixed`, one more spring at each end to the ground.
SparseMatrix<double> chain(Index size, bool fixed) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < size; ++i) {
    entries.emplace_back(i, i, !fixed && (i == 0 || i + 1 == size) ? 1.0 : 2.0);
    if (i > 0) entries.emplace_back(i, i - 1, -1.0), entries.emplace_back(i - 1, i, -1.0);
  }
  SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

SparseMatrix<double> kronecker_sum(const SparseMatrix<double>& a, const SparseMatrix<double>& b) {
  std::vector<Eigen::Triplet<double>> entries;
  const Index n = a.rows(), m = b.rows();
  for (Index j = 0; j < n; ++j)
    for (SparseMatrix<double>::InnerIterator it(a, j); it; ++it)
      for (Index k = 0; k < m; ++k) entries.emplace_back(it.row() * m + k, j * m + k, it.value());
  for (Index j = 0; j < m; ++j)
    for (SparseMatrix<double>::InnerIterator it(b, j); it; ++it)
      for (Index k = 0; k < n; ++k) entries.emplace_back(k * m + it.row(), k * m + j, it.value());
  SparseMatrix<double> matrix(n * m, n * m);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Phi^T M Phi = 1 to rounding, and the inequality that LowestModesOptions::tolerance states (found .9 of it; half as
/// much again, because the estimate that stops the iteration and this solution round differently).
void expect_eigenpairs(const SparseMatrix<double>& K, const SparseMatrix<double>& M, const LowestModes& modes) {
  const MatrixXd gram = modes.vectors.transpose() * (M * modes.vectors);
  EXPECT_LT((gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 5e-13);  // found 5e-14
  const StiffnessFactor factored = factor_stiffness(K, M);
  for (Index i = 0; i < modes.values.size(); ++i) {
    const VectorXd phi = modes.vectors.col(i);
    const VectorXd residual = (modes.values[i] + factored.shift) * factored.factor.solve(M * phi) - phi;
    EXPECT_LT(std::sqrt(residual.dot(M * residual)), 1.5 * LowestModesOptions{}.tolerance) << i;
  }
}

/// lambda_i of a chain of n masses m held at both ends by springs k: 4 k / m sin^2(i pi / (2 (n + 1))).
double fixed_chain_value(Index i, Index n) { return 4.0 * std::pow(std::sin(i * M_PI / (2.0 * (n + 1))), 2); }

TEST(LowestModes, FixedChainHasItsClosedForm) {
  for (const Index n : {30, 150, 2000, 5000})
    for (const ModeCheck check : {ModeCheck::automatic, ModeCheck::block, ModeCheck::sturm}) {
      const SparseMatrix<double> K = 7.0 * chain(n, true), M = diagonal(VectorXd::Constant(n, 0.5));
      const LowestModes modes = lowest_modes(K, M, {.count = 12, .check = check});
      ASSERT_EQ(modes.values.size(), 12);
      // found 7.5e-12: the condition number n^2 times a rounding
      for (Index i = 0; i < 12; ++i)
        EXPECT_NEAR(modes.values[i] / (14.0 * fixed_chain_value(i + 1, n)), 1.0, 1e-10) << n << " " << i;
      EXPECT_NEAR(modes.next.value() / (14.0 * fixed_chain_value(13, n)), 1.0, 1e-2);  // as the header states
      expect_eigenpairs(K, M, modes);
    }
}

TEST(LowestModes, FreeChainHasOneRigidMode) {
  for (const Index n : {20, 1000, 4000}) {
    const SparseMatrix<double> K = 1e6 * chain(n, false), M = diagonal(VectorXd::Ones(n));
    const LowestModes modes = lowest_modes(K, M, {.count = 6});
    EXPECT_EQ(modes.values[0], 0.0);
    // free ends: 4 k / m sin^2(i pi / (2 n)); found 2.5e-11: rounding times n^2, as above
    for (Index i = 1; i < 6; ++i)
      EXPECT_NEAR(modes.values[i] / (4e6 * std::pow(std::sin(i * M_PI / (2.0 * n)), 2)), 1.0, 3e-10) << n;
    EXPECT_LT((modes.vectors.col(0) - VectorXd::Constant(n, 1.0 / std::sqrt(double(n)))).norm(), 1e-11);  // found 9e-13
  }
}

TEST(LowestModes, FindsEveryCopyOfARepeatedEigenvalue) {
  // the square grid: lambda_ij = mu_i + mu_j, all with i != j double
  const Index side = 40;
  const double rounding = 6e-14;  // of eigenvalues up to 8, found 5e-15
  const SparseMatrix<double> K = kronecker_sum(chain(side, true), chain(side, true));
  std::vector<double> exact;
  for (Index i = 1; i <= side; ++i)
    for (Index j = 1; j <= side; ++j) exact.push_back(fixed_chain_value(i, side) + fixed_chain_value(j, side));
  std::ranges::sort(exact);
  for (const ModeCheck check : {ModeCheck::sturm, ModeCheck::block, ModeCheck::none})
    for (const Index count : {1, 2, 30, 31}) {
      const SparseMatrix<double> M = diagonal(VectorXd::Ones(side * side));
      const LowestModes modes = lowest_modes(K, M, {.count = count, .check = check});
      ASSERT_EQ(modes.values.size(), count);
      for (Index i = 0; i < count; ++i)
        EXPECT_NEAR(modes.values[i], exact[std::size_t(i)], rounding) << i << "/" << count;
      expect_eigenpairs(K, M, modes);
    }
}

TEST(LowestModes, FindsMoreCopiesThanABlockHolds) {
  // thirty equal chains beside each other: every eigenvalue thirtyfold, the first block is eight wide
  const Index length = 20, copies = 30;
  const double rounding = 5e-14;  // of eigenvalues up to 4, found 4e-15
  const SparseMatrix<double> K = kronecker_sum(SparseMatrix<double>(copies, copies), chain(length, true));
  const SparseMatrix<double> M = diagonal(VectorXd::Ones(length * copies));
  for (const ModeCheck check : {ModeCheck::sturm, ModeCheck::block}) {
    const LowestModes modes = lowest_modes(K, M, {.count = 75, .check = check});
    for (Index i = 0; i < 75; ++i)
      EXPECT_NEAR(modes.values[i], fixed_chain_value(1 + i / copies, length), rounding) << i;
    const LowestModes limited = lowest_modes(K, M, {.below = 1.01 * fixed_chain_value(2, length), .check = check});
    EXPECT_EQ(limited.values.size(), 60);
  }
}

TEST(LowestModes, ALimitIsCovered) {
  const Index n = 1500;
  const SparseMatrix<double> K = chain(n, true), M = diagonal(VectorXd::Ones(n));
  for (const Index inside : {0, 1, 5, 23, 24, 25, 110}) {
    const double limit = 0.5 * (fixed_chain_value(inside, n) + fixed_chain_value(inside + 1, n));
    const LowestModes modes = lowest_modes(K, M, {.below = limit});
    ASSERT_EQ(modes.values.size(), inside);
    if (inside > 0) {
      // found 1.6e-12: rounding times n^2
      EXPECT_NEAR(modes.values[inside - 1] / fixed_chain_value(inside, n), 1.0, 2e-11);
    }
    EXPECT_GT(modes.next.value(), limit);
    EXPECT_EQ(lowest_modes(K, M, {.count = 20, .below = limit}).values.size(), std::min<Index>(20, inside));
  }
}

SparseMatrix<double> random_definite(Index size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::uniform_int_distribution<Index> place(0, size - 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (Index k = 0; k < 3 * size; ++k) entries.emplace_back(place(random), place(random), value(random));
  SparseMatrix<double> factor(size, size), identity(size, size);
  factor.setFromTriplets(entries.begin(), entries.end());
  identity.setIdentity();
  return SparseMatrix<double>(factor * factor.transpose()) + 0.5 * identity;
}

TEST(LowestModes, MayBeWantedAboveTheLimitToo) {
  for (const Index n : {30, 150, 5000})
    for (const ModeCheck check : {ModeCheck::automatic, ModeCheck::block, ModeCheck::sturm})
      for (const auto& [in_limit, at_least] : {std::pair<Index, Index>{0, 7}, {3, 12}, {12, 12}, {12, 5}}) {
        const SparseMatrix<double> K = chain(n, true), M = diagonal(VectorXd::Ones(n));
        const double limit =
            0.5 * (in_limit == 0 ? fixed_chain_value(1, n)
                                 : fixed_chain_value(in_limit, n) + fixed_chain_value(in_limit + 1, n));
        const Index count = std::max(in_limit, at_least);
        const LowestModes modes = lowest_modes(K, M, {.below = limit, .at_least = at_least, .check = check});
        ASSERT_EQ(modes.values.size(), count) << n << " " << in_limit;
        EXPECT_NEAR(modes.values[count - 1] / fixed_chain_value(count, n), 1.0, 1e-10);
        EXPECT_NEAR(modes.next.value() / fixed_chain_value(count + 1, n), 1.0, 1e-2);
        expect_eigenpairs(K, M, modes);
        EXPECT_EQ(lowest_modes(K, M, {.count = 4, .below = limit, .at_least = at_least}).values.size(),
                  std::min<Index>(4, count));
      }
}

TEST(LowestModes, MayBeWantedBesideRigidOnes) {
  for (const Index n : {30, 5000}) {
    const SparseMatrix<double> K = chain(n, false), M = diagonal(VectorXd::Ones(n));
    const auto value = [n](Index i) { return 4.0 * std::pow(std::sin(double(i) * M_PI / (2.0 * double(n))), 2); };
    const LowestModes modes = lowest_modes(K, M, {.below = 0.5 * value(1), .at_least = 6});
    ASSERT_EQ(modes.values.size(), 6);
    EXPECT_EQ(modes.values[0], 0.0);
    EXPECT_NEAR(modes.values[5] / value(5), 1.0, 1e-10);
  }
}

TEST(LowestModes, EqualTheDenseSolversOfRandomPencils) {
  for (const Index n : {120, 400}) {
    const SparseMatrix<double> K = random_definite(n, 1), M = random_definite(n, 2);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> dense{MatrixXd(K), MatrixXd(M)};
    for (const Index count : {Index{5}, Index{40}, n}) {
      const LowestModes modes = lowest_modes(K, M, {.count = count});
      // rounding of two solvers, found 3e-14 of the highest value
      EXPECT_LT((modes.values - dense.eigenvalues().head(count)).cwiseAbs().maxCoeff(), 5e-13 * modes.values[count - 1])
          << n << " " << count;
      expect_eigenpairs(K, M, modes);
      EXPECT_EQ(modes.next.has_value(), count < n);
    }
  }
}

TEST(LowestModes, MassMayBeMissingInPlaces) {
  // masses at every second or every hundredth node only; the others are eliminated statically
  for (const Index spacing : {2, 100}) {
    const Index n = 1001, masses = (n - 1) / spacing;
    VectorXd mass = VectorXd::Zero(n);
    for (Index i = spacing; i < n; i += spacing) mass[i - 1] = 2.0;
    const SparseMatrix<double> K = chain(n, true), M = diagonal(mass);
    const LowestModes modes = lowest_modes(K, M, {.count = 6});
    // reference: the chain of the masses alone, springs 1 / spacing; its right end is not half a cell off for these n
    SparseMatrix<double> condensed = chain(masses, true) / double(spacing);
    condensed.coeffRef(masses - 1, masses - 1) = 1.0 / spacing + 1.0 / double(n + 1 - masses * spacing);
    const LowestModes reference = lowest_modes(condensed, diagonal(VectorXd::Constant(masses, 2.0)), {.count = 6});
    // rounding times n^2, found 4.3e-13
    EXPECT_LT((modes.values - reference.values).cwiseAbs().cwiseQuotient(reference.values).maxCoeff(), 5e-12);
    expect_eigenpairs(K, M, modes);
    EXPECT_THROW(lowest_modes(K, M, {.count = masses + 1}), InvalidInput);
  }
}

TEST(LowestModes, UnitsDoNotMatter) {
  const Index n = 600;
  const SparseMatrix<double> K = chain(n, false), M = diagonal(VectorXd::Ones(n));
  const LowestModes plain = lowest_modes(K, M, {.count = 10});
  for (const double scale : {1e-12, 1e12}) {
    const LowestModes scaled = lowest_modes(scale * K, M, {.count = 10});
    EXPECT_EQ(scaled.values[0], 0.0);
    // scales that are no powers of two round otherwise: times n^2, found 2.8e-12 and 1.7e-11
    EXPECT_LT((scaled.values / scale - plain.values).norm(), 3e-11 * plain.values.norm());
    EXPECT_LT((scaled.vectors.cwiseAbs() - plain.vectors.cwiseAbs()).norm(), 2e-10);
  }
}

TEST(LowestModes, AreTheSameEveryTime) {
  const SparseMatrix<double> K = chain(900, false), M = diagonal(VectorXd::Ones(900));
  const LowestModes one = lowest_modes(K, M, {.count = 9}), two = lowest_modes(K, M, {.count = 9});
  EXPECT_EQ(one.vectors, two.vectors);
  // both ends of an odd mode are largest, equal to rounding
  for (const auto& shape : one.vectors.colwise())
    EXPECT_GT(shape.maxCoeff(), (1.0 - 1e-9) * shape.cwiseAbs().maxCoeff());
}

TEST(LowestModes, SaysWhatIsWrongWithTheInput) {
  const SparseMatrix<double> K = chain(10, true), M = diagonal(VectorXd::Ones(10));
  EXPECT_THROW(lowest_modes(K, M, {}), InvalidInput);
  EXPECT_THROW(lowest_modes(K, M, {.count = 11}), InvalidInput);
  EXPECT_THROW(lowest_modes(K, M, {.count = -1}), InvalidInput);
  EXPECT_THROW(lowest_modes(K, diagonal(VectorXd::Ones(9)), {.count = 1}), InvalidInput);
  EXPECT_THROW(lowest_modes(-K, M, {.count = 1}), InvalidInput);
  EXPECT_THROW(lowest_modes(SparseMatrix<double>(10, 10), SparseMatrix<double>(10, 10), {.count = 1}), InvalidInput);
  EXPECT_EQ(lowest_modes(K, M, {.count = 0}).values.size(), 0);
}

}  // namespace
}  // namespace kalfem
