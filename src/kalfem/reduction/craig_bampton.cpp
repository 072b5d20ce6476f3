#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/sparse_select.hpp"
#include "kalfem/reduction/evidence.hpp"
#include "kalfem/reduction/mode_selection.hpp"
#include "kalfem/reduction/static_modes.hpp"
#include "kalfem/reduction/superelement.hpp"
#include "kalfem/reduction/truncation_vectors.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd frequencies(const VectorXd& values) { return values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi); }

/// T = [I 0; Psi Phi], its rows in the order of the full model.
MatrixXd transformation(const Partition& parts, const MatrixXd& static_part, const MatrixXd& modes) {
  const Index n_b = static_part.cols();
  const auto n = static_cast<Index>(parts.boundary.size() + parts.interior.size());
  MatrixXd T = MatrixXd::Zero(n, n_b + modes.cols());
  for (Index j = 0; j < n_b; ++j) T(parts.boundary[static_cast<std::size_t>(j)], j) = 1.0;
  for (std::size_t i = 0; i < parts.interior.size(); ++i) {
    const auto row = static_cast<Index>(i);
    T.row(parts.interior[i]) << static_part.row(row), modes.row(row);
  }
  return T;
}

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

SparseMatrix projected(const SparseMatrix& matrix, const MatrixXd& T) {
  return symmetric(T.transpose() * (matrix * T)).sparseView();
}

/// T^T M T; the modes are mass-normalised, so its last block is the identity.
SparseMatrix projected_mass(const SparseMatrix& mass, const MatrixXd& T, Index modes) {
  MatrixXd reduced(projected(mass, T));
  reduced.bottomRightCorner(modes, modes).setIdentity();
  return reduced.sparseView();
}

/// T^T K T; the static modes are in equilibrium in the interior, so no modes do work with them.
SparseMatrix projected_stiffness(const SparseMatrix& stiffness, const MatrixXd& T, const VectorXd& values) {
  const Index n_b = T.cols() - values.size();
  const auto static_part = T.leftCols(n_b);
  MatrixXd reduced = MatrixXd::Zero(T.cols(), T.cols());
  reduced.topLeftCorner(n_b, n_b) = symmetric(static_part.transpose() * (stiffness * static_part));
  reduced.diagonal().tail(values.size()) = values;
  return reduced.sparseView();
}

/// T^T (C + M Phi diag(rates) Phi^T M) T without the dense matrix in the middle.
SparseMatrix projected_damping(const LinearModel& model, const MatrixXd& T) {
  const SparseMatrix local = projected(model.damping, T);
  const auto& [modes, rates] = model.modal_damping;
  if (rates.size() == 0) return local;
  const MatrixXd momenta = T.transpose() * (model.mass * modes.shapes);
  return symmetric(MatrixXd(local) + momenta * rates.asDiagonal() * momenta.transpose()).sparseView();
}

std::vector<std::string> reduced_names(const std::vector<std::string>& boundary, Index modes, Index truncation) {
  std::vector<std::string> names = boundary;
  for (Index i = 1; i <= modes; ++i) names.push_back("mode" + std::to_string(i));
  for (Index i = 1; i <= truncation; ++i) names.push_back("truncation" + std::to_string(i));
  return names;
}

/// The kept modes with the truncation vectors behind them, where they are wanted.
LowestModes completed_modes(const LinearModel& model, const Partition& parts, const MatrixXd& static_part,
                            const LowestModes& kept, const SparseFactor& stiffness, bool with_truncation) {
  if (!with_truncation || parts.boundary.empty()) return kept;
  const auto further = truncation_vectors(parts, select(model.mass, parts.interior, parts.boundary), static_part,
                                          kept.vectors, stiffness);
  LowestModes all = kept;
  all.values.conservativeResize(kept.values.size() + further.values.size());
  all.values.tail(further.values.size()) = further.values;
  all.vectors.conservativeResize(Eigen::NoChange, all.values.size());
  all.vectors.rightCols(further.values.size()) = further.vectors;
  return all;
}

/// The points of the full model as combinations of the reduced degrees of freedom.
std::map<std::string, DofCombination> reduced_points(const LinearModel& model, const MatrixXd& T,
                                                     const std::vector<std::string>& names) {
  std::map<std::string, Index> places;
  for (Index i = 0; i < model.size(); ++i) places.emplace(model.dofs[static_cast<std::size_t>(i)], i);
  std::map<std::string, DofCombination> points;
  for (const auto& [point, combination] : model.points) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(T.cols());
    for (const auto& [dof, coefficient] : combination) row += coefficient * T.row(places.at(dof));
    DofCombination& reduced = points[point];
    for (Index j = 0; j < row.size(); ++j)
      if (row[j] != 0.0) reduced[names[static_cast<std::size_t>(j)]] = row[j];
  }
  return points;
}

LinearModel reduced_model(const LinearModel& model, const MatrixXd& T, const VectorXd& values,
                          std::vector<std::string> names) {
  LinearModel reduced;
  reduced.mass = projected_mass(model.mass, T, values.size());
  reduced.damping = projected_damping(model, T);
  reduced.stiffness = projected_stiffness(model.stiffness, T, values);
  for (const auto& ground : model.grounds)
    reduced.grounds.push_back({ground.ground, T.transpose() * ground.stiffness, T.transpose() * ground.damping});
  reduced.points = reduced_points(model, T, names);
  reduced.points_only = model.points_only;
  reduced.dofs = std::move(names);
  return reduced;
}

double comparison_band(const ReductionEvidence& evidence, const ReductionOptions& options) {
  if (options.compare_up_to > 0.0) return options.compare_up_to;
  return 0.5 * (evidence.highest_kept > 0.0 ? evidence.highest_kept : evidence.next_left_out);
}

std::vector<std::string> all_kept(const std::vector<std::string>& boundary, const ReductionOptions& options) {
  std::vector<std::string> names = boundary;
  for (const auto& name : options.also_kept)
    if (std::ranges::find(boundary, name) == boundary.end()) names.push_back(name);
  return names;
}

}  // namespace

Superelement craig_bampton(const LinearModel& model, const std::vector<std::string>& boundary,
                           const ReductionOptions& options) {
  const Stopwatch watch;
  const std::vector<std::string> names = all_kept(boundary, options);
  const Partition parts = partition(model, names);
  const ShiftedStiffness factored = factor_stiffness(parts.stiffness_ii, parts.mass_ii, parts.interior_names);
  const MatrixXd static_part = static_modes(parts, factored, rigid_body_modes(parts, factored));
  const SelectedModes selected = select_modes(parts, static_part * translations(names), factored, options.modes);
  const VectorXd kept = frequencies(selected.modes.values);

  const LowestModes modes =
      completed_modes(model, parts, static_part, selected.modes, factored.factor, options.truncation_vectors);

  Superelement element;
  element.boundary = parts.boundary;
  element.basis = transformation(parts, static_part, modes.vectors);
  element.model = reduced_model(model, element.basis, modes.values,
                                reduced_names(names, kept.size(), modes.values.size() - kept.size()));
  ReductionEvidence& evidence = element.evidence;
  evidence.static_error = static_error(parts, static_part);
  evidence.interface_frequencies = kept;
  evidence.highest_kept = kept.size() > 0 ? kept.tail(1)[0] : 0.0;
  evidence.next_left_out = frequencies(VectorXd::Constant(1, selected.modes.next.value_or(0.0)))[0];
  evidence.rigid_modes = selected.rigid;
  evidence.reason = selected.reason;
  if (const Index further = modes.values.size() - kept.size(); further > 0)
    evidence.reason += ", " + std::to_string(further) + " truncation vectors";
  evidence.factor_bytes = factored.factor.bytes();
  evidence.solves = selected.modes.solves + static_part.cols();
  evidence.seconds = watch.seconds();
  if (options.evidence)
    evidence.modes = compare_modes(model, element.model, element.basis, comparison_band(evidence, options));
  return element;
}

Superelement guyan(const LinearModel& model, const std::vector<std::string>& boundary,
                   const ReductionOptions& options) {
  ReductionOptions without_modes = options;
  without_modes.modes = {.count = 0};
  return craig_bampton(model, boundary, without_modes);
}

}  // namespace kalfem
