// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/projection.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <ranges>

#include "kalfem/linalg/long_products.hpp"
#include "kalfem/linalg/tall_matrices.hpp"
#include "kalfem/reduction/combinations.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Part of a column's size that the others must leave for it to count.
constexpr double least_remainder = 1e-5;

}  // namespace

void orthonormalise(LongVectors& X, const VectorXd& scale, const SparseMatrix& mass) {
  if (X.capacity() == 0) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> products(scale.asDiagonal() * gram(X, mass, X.capacity()) *
                                                         scale.asDiagonal());
  const Index independent = (products.eigenvalues().array() > least_remainder * least_remainder).count();
  const VectorXd sizes = products.eigenvalues().tail(independent).cwiseSqrt();
  X.combine(scale.asDiagonal() * products.eigenvectors().rightCols(independent) * sizes.cwiseInverse().asDiagonal());
  X.reserve(independent);
}

VectorXd uncouple(LongVectors& X, const SparseMatrix& stiffness, const SparseMatrix& mass) {
  const Index count = X.capacity();
  if (count == 0) return {};
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(gram(X, stiffness, count), gram(X, mass, count));
  X.combine(pairs.eigenvectors());
  return pairs.eigenvalues();
}

namespace {

// A model in the coordinates p, z = T p with T = [Psi Phi; 1 0] in the order interior, boundary: constraint modes or
// other static shapes first, then modes of the interior with the boundary held. What is known exactly is not computed
// by products, which would leave rounding in its place: Phi^T M Phi = 1, Phi^T K Phi = diag(lambda) and
// Psi^T K Phi = 0 [CB68].
SparseMatrix projected_mass(const SparseMatrix& mass, const LongVectors& T, Index modes) {
  const Index r = T.capacity();
  MatrixXd reduced = MatrixXd::Identity(r, r);
  visit_products(mass, T, r - modes, [&](Index first, const TallMatrix& panel, const TallMatrix& inertia) {
    reduced.block(first, first, r - first, panel.cols()) = T.products(first, r, inertia);
  });
  return MatrixXd(reduced.selfadjointView<Eigen::Lower>()).sparseView();
}

SparseMatrix projected_stiffness(const SparseMatrix& stiffness, const LongVectors& T, const VectorXd& values) {
  const Index n_b = T.capacity() - values.size();
  const VectorXd diagonal = stiffness.diagonal();
  VectorXd scale = VectorXd::Zero(n_b);  // of the energies that cancel in a coordinate's
  MatrixXd static_part = MatrixXd::Zero(n_b, n_b);
  visit_products(stiffness, T, n_b, [&](Index first, const TallMatrix& panel, const TallMatrix& forces) {
    static_part.block(first, first, n_b - first, panel.cols()) = T.products(first, n_b, forces);
    scale.segment(first, panel.cols()) = panel.cwiseAbs2().transpose() * diagonal;
  });
  MatrixXd reduced = MatrixXd::Zero(T.capacity(), T.capacity());
  reduced.topLeftCorner(n_b, n_b) = static_part.selfadjointView<Eigen::Lower>();
  // The energy of a coordinate that moves the whole rigidly is rounding, of either sign.
  for (Index j = 0; j < n_b; ++j)
    if (reduced(j, j) <= std::numeric_limits<double>::epsilon() * scale[j]) {
      reduced.row(j).setZero();
      reduced.col(j).setZero();
    }
  reduced.diagonal().tail(values.size()) = values;
  return reduced.sparseView();
}

SparseMatrix projected_damping(const LinearModel& model, const LongVectors& T) {
  const Index r = T.capacity();
  const MatrixXd local = gram(T, model.damping, r);
  const auto& [modes, rates] = model.modal_damping;
  if (rates.size() == 0) return local.sparseView();
  const MatrixXd mass_weighted_modes = T.products(0, r, model.mass * modes.shapes);
  return symmetric(local + mass_weighted_modes * rates.asDiagonal() * mass_weighted_modes.transpose()).sparseView();
}

/// Combinations of the full model's degrees of freedom as those of the reduced ones.
std::map<std::string, DofCombination> projected(const std::map<std::string, DofCombination>& combinations,
                                                const CombinationRows& rows, const MatrixXd& T,
                                                const std::vector<std::string>& names) {
  std::map<std::string, DofCombination> all;
  for (const auto& [name, combination] : combinations) {
    const Eigen::RowVectorXd row = rows.value(combination, T);
    DofCombination& reduced = all[name];
    for (Index j = 0; j < row.size(); ++j)
      if (row[j] != 0.0) reduced[names[static_cast<std::size_t>(j)]] = row[j];
  }
  return all;
}

}  // namespace

VectorXd natural_frequencies(const VectorXd& values) {
  return values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

// From the last column to the first: the shapes shrink as T grows, whose memory is taken where it is written.
std::unique_ptr<LongVectors> transformation(const Partition& parts, const std::vector<LongVectors*>& shapes) {
  constexpr Index widest = 8;
  const auto n_b = static_cast<Index>(parts.boundary.size()), n = n_b + static_cast<Index>(parts.interior.size());
  Index r = 0;
  for (const LongVectors* part : shapes) r += part->capacity();
  auto T = make_long_vectors(n);
  T->reserve(r);
  MatrixXd columns(n, widest);
  Index end = r;
  for (LongVectors* part : std::views::reverse(shapes))
    while (const Index count = std::min(widest, part->capacity())) {
      const Index rest = part->capacity() - count;
      end -= count;
      columns(parts.interior, Eigen::seqN(0, count)) = part->columns(rest, rest + count);
      columns(parts.boundary, Eigen::seqN(0, count)) = MatrixXd::Identity(n_b, r).middleCols(end, count);
      T->put(end, columns.leftCols(count));
      part->reserve(rest);
    }
  return T;
}

LinearModel projected_model(const LinearModel& model, const LongVectors& T, const VectorXd& values) {
  LinearModel reduced;
  reduced.mass = projected_mass(model.mass, T, values.size());
  reduced.damping = projected_damping(model, T);
  reduced.stiffness = projected_stiffness(model.stiffness, T, values);
  return reduced;
}

void carry_over(const LinearModel& model, const MatrixXd& T, std::vector<std::string> names, LinearModel& reduced) {
  for (const auto& ground : model.grounds)
    reduced.grounds.push_back({ground.ground, T.transpose() * ground.stiffness, T.transpose() * ground.damping});
  const CombinationRows rows(model);
  reduced.points = projected(model.points, rows, T, names);
  reduced.gauges = projected(model.gauges, rows, T, names);
  reduced.points_only = model.points_only;
  reduced.dofs = std::move(names);
}

std::vector<std::string> joined(const std::vector<std::string>& boundary, const std::vector<std::string>& also_kept) {
  std::vector<std::string> names = boundary;
  for (const auto& name : also_kept)
    if (std::ranges::find(boundary, name) == boundary.end()) names.push_back(name);
  return names;
}

}  // namespace kalfem
