// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace kalfem {

class SinglePrecisionFactor;

/// The matrix to be factored is not positive definite to rounding; `column` is where it shows first, in the numbering
/// of the matrix that was given.
class NotPositiveDefinite : public std::runtime_error {
public:
  explicit NotPositiveDefinite(Eigen::Index column);
  [[nodiscard]] Eigen::Index column() const { return column_; }

private:
  Eigen::Index column_;
};

/// A fill-reducing order of elimination: position j of the factor is row order[j] of the matrix.
using EliminationOrder = std::vector<std::int64_t>;

/// Sparse Cholesky factor P A P^T = L L^T of a symmetric positive-definite matrix, n x n (CHOLMOD [CDHR08]: supernodal
/// where that pays, ordered by minimum degree or nested dissection, whichever fills less).
///
/// A pivot L_jj^2 below 1e-13 A_jj counts as zero: a singular matrix leaves pivots of a few hundred roundings, and a
/// regular one with such a pivot would leave no three digits of the solution.
/// Solving does not allocate once it was done with as many right-hand sides, up to 32; one thread at a time.
class SparseFactor {
public:
  /// Only the upper triangle is read. Throws NotPositiveDefinite, and InvalidInput where A is not square.
  /// With an `order` of a matrix with the same pattern none is looked for, which is a good part of the work; of
  /// another size it is refused with InvalidInput. `springs`, n x 1, are added to the diagonal, where they are given.
  explicit SparseFactor(const Eigen::SparseMatrix<double>& matrix, const EliminationOrder& order = {},
                        const Eigen::VectorXd& springs = {});
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  /// Another matrix with the same pattern in its upper triangle: the symbolic analysis is kept. Throws
  /// NotPositiveDefinite, after which only another refactor() makes sense, and InvalidInput where the pattern differs.
  void refactor(const Eigen::SparseMatrix<double>& matrix);

  /// X = A^-1 B, n x k; X and B may be the same. Many right-hand sides at once cost far less than one by one.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side, Eigen::Ref<Eigen::MatrixXd> solution) const;
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side) const;

  [[nodiscard]] Eigen::Index size() const;
  [[nodiscard]] EliminationOrder order() const;
  [[nodiscard]] double nonzeros() const;  ///< entries of L, with the zeros that supernodes store
  [[nodiscard]] double bytes() const;     ///< memory of L [byte]
  /// min_j L_jj^2 / A_jj, how near to singular A is whatever its units; of the order of the flexibility of the last
  /// degree of freedom alone against that of the whole structure there.
  [[nodiscard]] double smallest_pivot() const;
  /// A copy of L in single precision; nothing where L is so sparse that it is not supernodal, or distributed.
  [[nodiscard]] std::optional<SinglePrecisionFactor> in_single_precision() const;

private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

/// X with K X = B, n x k, for a positive semi-definite K, n x n, and B in its range: K is factored with a shift far
/// below what matters in it, and X refined with K itself, so that motions without strain stay out of X.
Eigen::MatrixXd semidefinite_solve(const Eigen::SparseMatrix<double>& matrix, const Eigen::MatrixXd& right_side);

}  // namespace kalfem
