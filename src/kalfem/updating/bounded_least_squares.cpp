// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/gauss_newton.hpp"

#include <cassert>
#include <vector>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A pull on a held unknown smaller than this, relative to the lengths of its column and of the offset, is rounding.
constexpr double rounding = 1e-13;

/// argmin |A y + b| of least length in columns scaled to length one; a column of zeros leaves its unknown at zero.
VectorXd least_squares(MatrixXd matrix, const VectorXd& offset, double rank_tolerance) {
  VectorXd length = matrix.colwise().norm();
  length = (length.array() > 0.0).select(length, 1.0);
  matrix *= length.cwiseInverse().asDiagonal();
  Eigen::JacobiSVD<MatrixXd> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(rank_tolerance);
  return -svd.solve(offset).cwiseQuotient(length);
}

// Minimises |A d + b| within lower <= d <= upper by an active-set method:
//   1. unknowns that stand at a bound and are pulled outwards are held from the start;
//   2. the free ones move to their common minimum, by least squares of least length; the first bound on the way stops
//      the move and holds its unknown;
//   3. where nothing stopped them, the held one that is pulled inwards most is freed; where none is, this is the
//      minimum.
// The cost falls with every move, so no set of held unknowns comes twice but by rounding, which the round limit ends.
/// The search: unknowns d, those that are held at a bound and the others.
class ActiveSet {
public:
  ActiveSet(const MatrixXd& matrix, const VectorXd& offset, const VectorXd& lower, const VectorXd& upper,
            double rank_tolerance)
      : matrix_(matrix), offset_(offset), lower_(lower), upper_(upper), rank_tolerance_(rank_tolerance) {
    const VectorXd pull = gradient();
    for (Index i = 0; i < unknowns_.size(); ++i)
      held_[static_cast<std::size_t>(i)] =
          lower_[i] == upper_[i] || (upper_[i] == 0.0 && pull[i] < 0.0) || (lower_[i] == 0.0 && pull[i] > 0.0);
  }

  VectorXd solve() {
    for (Index round = 0; round < 10 * unknowns_.size() + 10; ++round)
      if (move_free() && !release_one()) break;
    return unknowns_;
  }

private:
  [[nodiscard]] VectorXd gradient() const { return matrix_.transpose() * (matrix_ * unknowns_ + offset_); }

  [[nodiscard]] std::vector<Index> free() const {
    std::vector<Index> indices;
    for (Index i = 0; i < unknowns_.size(); ++i)
      if (!held_[static_cast<std::size_t>(i)]) indices.push_back(i);
    return indices;
  }

  /// Moves the free unknowns towards their minimum up to the first bound, which then holds its unknown. True where none
  /// was in the way.
  bool move_free() {
    const auto indices = free();
    if (indices.empty()) return true;
    VectorXd others = unknowns_;
    others(indices).setZero();
    VectorXd target = others;
    target(indices) = least_squares(matrix_(Eigen::all, indices), offset_ + matrix_ * others, rank_tolerance_);
    double share = 1.0;
    Index blocking = -1;
    for (const Index i : indices) {
      const double bound = target[i] < lower_[i] ? lower_[i] : upper_[i];
      if (target[i] >= lower_[i] && target[i] <= upper_[i]) continue;
      const double until = (bound - unknowns_[i]) / (target[i] - unknowns_[i]);
      if (until <= share) share = until, blocking = i;
    }
    unknowns_ += share * (target - unknowns_);
    unknowns_ = unknowns_.cwiseMax(lower_).cwiseMin(upper_);
    if (blocking < 0) return true;
    unknowns_[blocking] = target[blocking] < lower_[blocking] ? lower_[blocking] : upper_[blocking];
    held_[static_cast<std::size_t>(blocking)] = true;
    return false;
  }

  /// Frees the held unknown that the residual pulls inwards most. False where there is none.
  bool release_one() {
    const VectorXd pull = gradient();
    double most = 0.0;
    Index released = -1;
    for (Index i = 0; i < unknowns_.size(); ++i) {
      if (!held_[static_cast<std::size_t>(i)] || lower_[i] == upper_[i]) continue;
      const double length = matrix_.col(i).norm() * offset_.norm();
      const double inwards = unknowns_[i] == lower_[i] ? -pull[i] : pull[i];
      if (inwards > rounding * length && inwards / length > most) most = inwards / length, released = i;
    }
    if (released < 0) return false;
    held_[static_cast<std::size_t>(released)] = false;
    return true;
  }

  const MatrixXd& matrix_;
  const VectorXd& offset_;
  const VectorXd& lower_;
  const VectorXd& upper_;
  double rank_tolerance_;
  VectorXd unknowns_ = VectorXd::Zero(matrix_.cols());
  std::vector<bool> held_ = std::vector<bool>(static_cast<std::size_t>(matrix_.cols()), false);
};

}  // namespace

VectorXd bounded_least_squares(const MatrixXd& matrix, const VectorXd& offset, const VectorXd& lower,
                               const VectorXd& upper, double rank_tolerance) {
  assert((lower.array() <= 0.0).all() && (upper.array() >= 0.0).all());
  return ActiveSet(matrix, offset, lower, upper, rank_tolerance).solve();
}

}  // namespace kalfem
