// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/sparse_factor.hpp"

#include <cassert>
#include <string>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/factor_workspace.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

NotPositiveDefinite::NotPositiveDefinite(Index column)
    : std::runtime_error("the matrix is not positive definite: zero or negative pivot in column " +
                         std::to_string(column)),
      column_(column) {}

/// The library that factors, and what the next matrix must have in common with the one that was analysed.
struct SparseFactor::Workspace {
  Workspace(const UpperTriangle& matrix, const EliminationOrder& order)
      : size(matrix.size), pattern(matrix.pattern()), factor(make_factor_workspace(matrix, order)) {
    factor->factorize(matrix);
  }

  Index size;
  std::uint64_t pattern;
  std::unique_ptr<FactorWorkspace> factor;
};

SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& matrix, const EliminationOrder& order,
                           const Eigen::VectorXd& springs) {
  if (matrix.rows() != matrix.cols())
    throw InvalidInput("a " + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) + " matrix",
                       "only a square matrix has a Cholesky factor", "pass a symmetric matrix");
  if (!order.empty() && static_cast<Index>(order.size()) != matrix.rows())
    throw InvalidInput(
        "an order of " + std::to_string(order.size()) + " rows for a matrix of " + std::to_string(matrix.rows()),
        "it must contain each row once", "pass the order of a factor of the same size");
  workspace_ = std::make_unique<Workspace>(UpperTriangle(matrix, springs), order);
}

SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

void SparseFactor::refactor(const Eigen::SparseMatrix<double>& matrix) {
  const UpperTriangle given(matrix);
  if (given.size != size() || given.pattern() != workspace_->pattern)
    throw InvalidInput("the matrix has a different pattern from the one analysed", "its factor has a different size",
                       "make a new SparseFactor or keep explicit zeros");
  workspace_->factor->factorize(given);
}

void SparseFactor::solve(const Eigen::Ref<const MatrixXd>& right_side, Eigen::Ref<MatrixXd> solution) const {
  assert(right_side.rows() == size() && solution.rows() == size() && solution.cols() == right_side.cols());
  if (right_side.size() > 0) workspace_->factor->solve(right_side, solution);
}

MatrixXd SparseFactor::solve(const Eigen::Ref<const MatrixXd>& right_side) const {
  MatrixXd solution(right_side.rows(), right_side.cols());
  solve(right_side, solution);
  return solution;
}

Index SparseFactor::size() const { return workspace_->size; }
EliminationOrder SparseFactor::order() const { return workspace_->factor->order(); }
double SparseFactor::nonzeros() const { return workspace_->factor->nonzeros(); }
double SparseFactor::bytes() const { return workspace_->factor->bytes(); }
double SparseFactor::smallest_pivot() const { return workspace_->factor->smallest_pivot(); }
std::optional<SinglePrecisionFactor> SparseFactor::in_single_precision() const {
  return workspace_->factor->in_single_precision();
}

using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

MatrixXd semidefinite_solve(const Matrix& matrix, const MatrixXd& right_side) {
  constexpr double relative_shift = 1e-12, tolerance = 1e-11;
  constexpr int most_refinements = 50;
  const VectorXd diagonal = matrix.diagonal();
  const double elsewhere = diagonal.maxCoeff() > 0.0 ? diagonal.maxCoeff() : 1.0;
  Matrix shifted = matrix;
  Matrix shift(diagonal.size(), diagonal.size());
  shift.reserve(Eigen::VectorXi::Ones(diagonal.size()));
  for (Index i = 0; i < diagonal.size(); ++i)
    shift.insert(i, i) = diagonal[i] > 0.0 ? relative_shift * diagonal[i] : elsewhere;
  shifted += shift;
  const SparseFactor factor(shifted);
  MatrixXd solution = factor.solve(right_side);
  for (int i = 0; i < most_refinements; ++i) {
    const MatrixXd correction = factor.solve(right_side - matrix * solution);
    solution += correction;
    if (correction.norm() <= tolerance * solution.norm()) break;
  }
  return solution;
}

}  // namespace kalfem
