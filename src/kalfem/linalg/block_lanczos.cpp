// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/block_lanczos.hpp"

#include <cmath>

#include "kalfem/base/interruption.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// What is smaller than this against the operator's image is rounding, not a new direction.
constexpr double no_direction = 1e-14;

}  // namespace

BlockLanczos::BlockLanczos(const StiffnessFactor& factor, const Eigen::SparseMatrix<double>& mass, Index width,
                           Index capacity)
    : factor_(factor), mass_(mass), width_(width), basis_(make_long_vectors(mass.rows())) {
  set_capacity(capacity);
}

/// V = A^-1 M V.
void BlockLanczos::apply() {
  solves_ += mass_weighted_modes_.cols();
  block_.resize(mass_.rows(), mass_weighted_modes_.cols());
  factor_.respond(mass_weighted_modes_, block_);
}

/// Makes the columns of V M-orthonormal, V = V' T with V' and M V' in place of V and M V; directions shorter than
/// `shortest` are dropped, so that T is r x k.
MatrixXd BlockLanczos::normalise(double shortest) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(block_.transpose() * mass_weighted_modes_);
  const Index dropped = (gram.eigenvalues().array() <= shortest * shortest).count();  // ascending: the first ones
  const Index kept = block_.cols() - dropped;
  const Eigen::VectorXd lengths = gram.eigenvalues().tail(kept).cwiseSqrt();
  const MatrixXd directions = gram.eigenvectors().rightCols(kept);
  const MatrixXd scaled = directions * lengths.cwiseInverse().asDiagonal();
  for (MatrixXd* columns : {&block_, &mass_weighted_modes_}) {
    scratch_.noalias() = *columns * scaled;
    columns->swap(scratch_);
  }
  return lengths.asDiagonal() * directions.transpose();
}

/// Splits V as Q projections + Q' triangle and puts Q' behind the first `columns` of the basis. The first pass takes
/// the part in the columns from `near` on, where there is any but rounding; the second, after the normalisation, what
/// rounding and cancellation have left in all of them.
void BlockLanczos::attach(Index near, Index columns, MatrixXd& projections, MatrixXd& triangle) {
  mass_weighted_modes_.noalias() = mass_ * block_;
  const double scale = std::sqrt(block_.cwiseProduct(mass_weighted_modes_).colwise().sum().maxCoeff());
  projections.setZero(columns, block_.cols());
  projections.bottomRows(columns - near) = basis_->project_out(near, columns, mass_weighted_modes_, block_);
  mass_weighted_modes_.noalias() = mass_ * block_;
  triangle = normalise(no_direction * scale);
  const MatrixXd remainder = basis_->project_out(0, columns, mass_weighted_modes_, block_);
  mass_weighted_modes_.noalias() = mass_ * block_;
  projections += remainder * triangle;
  triangle = normalise(0.5) * triangle;  // nothing that is left had length 1: it lay in the basis
  last_ = block_.cols();
  basis_->put(columns, block_);
}

// A block Lanczos step with full second orthogonalisation: apply A^-1 M to the last block, take out the part that lies
// in the basis, M-orthonormalise the rest and append it. The projections are one block column of Q^T M A^-1 M Q, the
// triangle couples it with the new block; the residual of a Ritz pair follows from that triangle alone.
bool BlockLanczos::step() {
  stop_if_asked();
  if (last_ == 0) return false;
  const Index columns = size_ + last_;
  const Index begin = size_, width = last_;
  apply();
  MatrixXd projections, triangle;
  attach(coupled_, columns, projections, triangle);

  projected_.conservativeResize(columns, columns);
  projected_.middleCols(begin, width) = projections;
  projected_.middleRows(begin, width) = projections.transpose();
  coupling_.setZero(last_, columns);
  coupling_.middleCols(begin, width) = triangle;
  coupled_ = begin;
  size_ = columns;
  return true;
}

bool BlockLanczos::restart_at_random() {
  block_.resize(mass_.rows(), width_);
  for (double& value : block_.reshaped()) value = std::ldexp(random_(), -31) - 1.0;
  mass_weighted_modes_.noalias() = mass_ * block_;
  apply();
  MatrixXd projections, triangle;
  attach(0, size_, projections, triangle);
  coupling_.setZero(last_, size_);
  coupled_ = 0;  // not with them but with what of their images the block that is replaced held
  return last_ > 0;
}

// Thick restart: the leading Ritz vectors take the place of the basis, their values that of the projected matrix, and
// the last block stays, coupled with all of them. Nothing that has converged is lost, and the memory stays bounded.
void BlockLanczos::compress(const RitzPairs& pairs, Index keep) {
  const auto kept = pairs.vectors.leftCols(keep);
  basis_->combine(kept);
  basis_->put(keep, block_);
  projected_ = pairs.values.head(keep).asDiagonal();
  coupling_ = (coupling_ * kept).eval();
  coupled_ = 0;
  size_ = keep;
}

RitzPairs BlockLanczos::pairs() const {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (projected_ + projected_.transpose()));
  RitzPairs pairs{solver.eigenvalues().reverse(), {}, solver.eigenvectors().rowwise().reverse()};
  pairs.residuals = (coupling_ * pairs.vectors).colwise().norm().transpose();
  return pairs;
}

MatrixXd BlockLanczos::vectors(const RitzPairs& pairs, Index count) const {
  return basis_->combination(pairs.vectors.leftCols(count));
}

}  // namespace kalfem
