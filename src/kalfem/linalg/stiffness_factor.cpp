// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/stiffness_factor.hpp"

#include <algorithm>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

constexpr double rigid_energy = 1e-12;
constexpr double doubtful_pivot = 1e-10;

double natural_shift(const Matrix& stiffness, const Matrix& mass) {
  const VectorXd k = stiffness.diagonal(), m = mass.diagonal();
  std::vector<double> ratios;
  for (Index j = 0; j < k.size(); ++j)
    if (k[j] > 0.0 && m[j] > 0.0) ratios.push_back(k[j] / m[j]);
  if (ratios.empty()) return 1.0;  // no stiffness anywhere: every mode is at zero, whatever the shift
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return 1e-8 * *middle;
}

/// Nothing where the matrix is singular, or a pivot is so small that it may be the rounding of a large model's zero.
std::optional<SparseFactor> safely_definite(const Matrix& matrix, const EliminationOrder& order,
                                            const VectorXd& springs = {}) {
  try {
    SparseFactor factor(matrix, order, springs);
    if (factor.smallest_pivot() < doubtful_pivot) return {};
    return factor;
  } catch (const NotPositiveDefinite&) {
    return {};
  }
}

}  // namespace

void StiffnessFactor::respond(const Eigen::Ref<const MatrixXd>& loads, Eigen::Ref<MatrixXd> displacements) const {
  if (rigid_modes.cols() == 0) return factor.solve(loads, displacements);
  const MatrixXd resultants = rigid_modes.transpose() * loads;
  displacements = loads;
  displacements.noalias() -= rigid_momentum * resultants;
  factor.solve(displacements, displacements);
  const MatrixXd motions = rigid_momentum.transpose() * displacements;
  displacements.noalias() -= rigid_modes * motions;
}

StiffnessFactor factor_stiffness(const Matrix& stiffness, const Matrix& mass, std::span<const std::string> names,
                                 const EliminationOrder& order) {
  if (auto factor = safely_definite(stiffness, order)) return {std::move(*factor)};
  const double shift = natural_shift(stiffness, mass);
  try {
    return {SparseFactor(stiffness + shift * mass, order), shift};
  } catch (const NotPositiveDefinite& error) {
    const auto column = static_cast<std::size_t>(error.column());
    throw InvalidInput("degree of freedom " + (names.empty() ? std::to_string(column) : "'" + names[column] + "'") +
                           " takes part in a motion that has no stiffness and no mass, or negative stiffness",
                       "K must be positive semi-definite, and motions without stiffness need mass",
                       "fix that degree of freedom or give it a mass");
  }
}

std::optional<StiffnessFactor> factor_held(const Matrix& stiffness, const Matrix& mass, const MatrixXd& motions) {
  const MatrixXd momentum = mass * motions;
  const Eigen::LLT<MatrixXd> gram(motions.transpose() * momentum);
  if (motions.cols() > 0 && (gram.info() != Eigen::Success || gram.rcond() < 1e-12)) return {};
  auto factor = safely_definite(stiffness, {}, supports(stiffness, motions));
  if (!factor) return {};
  const auto orthonormal = [&](const MatrixXd& columns) -> MatrixXd {
    return gram.matrixU().solve<Eigen::OnTheRight>(columns);
  };
  return StiffnessFactor{std::move(*factor), 0.0, orthonormal(motions), orthonormal(momentum)};
}

// The best degrees of freedom are those of the pivots of R^T, each row of R by the stiffness there, so that rotations
// and translations compare.
VectorXd supports(const Matrix& stiffness, const MatrixXd& motions) {
  const VectorXd diagonal = stiffness.diagonal();
  VectorXd springs = VectorXd::Zero(diagonal.size());
  if (motions.cols() == 0) return springs;
  MatrixXd scaled = motions.transpose() * diagonal.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::Ref<MatrixXd>> pivots(scaled);  // in its place
  for (const Index dof : pivots.colsPermutation().indices().head(motions.cols())) springs[dof] = diagonal[dof];
  return springs;
}

bool moves_rigidly(const Matrix& stiffness, const Eigen::Ref<const VectorXd>& shape) {
  return shape.dot(stiffness * shape) <= rigid_energy * stiffness.diagonal().dot(shape.cwiseAbs2());
}

}  // namespace kalfem
