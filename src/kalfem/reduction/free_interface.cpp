// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/free_interface.hpp"

#include <algorithm>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/tall_matrices.hpp"
#include "kalfem/reduction/comparison.hpp"
#include "kalfem/reduction/interior_statics.hpp"
#include "kalfem/reduction/mode_selection.hpp"
#include "kalfem/reduction/projection.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same_motion = 1e-9;     ///< a rigid-body motion that moves the boundary less than this moves it not
constexpr double no_flexibility = 1e-9;  ///< of the residual flexibility scaled to a unit diagonal

void require_free_modes(const ModeSelection& selection) {
  IssueList issues;
  if (selection.effective_mass)
    issues.add({}, "effective_mass is given for a free-interface reduction",
               "elastic modes of a free component carry no mass in a translation",
               "give a number of modes or a frequency");
  else if (!selection.count && !selection.cutoff)
    issues.add({}, "the number of free-interface modes is not given",
               "a free-interface reduction needs a number of modes or a frequency", "give one of them");
  issues.raise();
}

struct FreeModes {
  SelectedModes selected;
  double factor_bytes = 0.0;
};

/// Modes of the component with nothing held: those of the interior of an empty boundary.
FreeModes free_modes(const LinearModel& model, const ModeSelection& selection, const StiffnessFactor* at_hand) {
  const Partition whole = partition(model, {});
  const auto modes = [&](const StiffnessFactor& factored) -> FreeModes {
    return {select_modes(whole, MatrixXd(model.size(), 0), factored, selection), factored.factor.bytes()};
  };
  if (at_hand) return modes(*at_hand);
  return modes(factor_stiffness(whole.stiffness_ii, whole.mass_ii, whole.interior_names));
}

/// Orthonormal basis of the rigid-body motions, as combinations of all of them, that boundary forces can cause.
MatrixXd caused_by_boundary(const MatrixXd& at_boundary) {
  if (at_boundary.size() == 0) return MatrixXd(at_boundary.cols(), 0);
  const Eigen::JacobiSVD<MatrixXd> parts(at_boundary, Eigen::ComputeThinV);
  const VectorXd& sizes = parts.singularValues();
  return parts.matrixV().leftCols((sizes.array() > same_motion * sizes[0]).count());
}

MatrixXd unit_columns(MatrixXd columns, const SparseMatrix& mass) {
  for (auto column : columns.colwise())
    if (const double size = std::sqrt(column.dot(mass * column)); size > 0.0) column /= size;
  return columns;
}

/// What the superelement is made of, in Rubin's kind.
struct Space {
  std::unique_ptr<LongVectors> static_part;  ///< n_i x n_b
  std::unique_ptr<LongVectors> modes;        ///< with the boundary held, uncoupled, n_i x m
  VectorXd values = {};                      ///< of the modes [(rad/s)^2]
  Index solves = 0;
  double factor_bytes = 0.0;
};

/// The free modes' interior less its static motion with their boundary, Phi_i - Psi Phi_b, and the responses beside
/// them.
std::unique_ptr<LongVectors> held_shapes(const Partition& parts, const LongVectors& static_part,
                                         const MatrixXd& free_modes, const MatrixXd& responses) {
  const Index count = free_modes.cols();
  auto shapes = make_long_vectors(responses.rows());
  shapes->reserve(count + responses.cols());
  by_panels(count, widest_panel, [&](Index first, Index width) {
    const auto panel = free_modes.middleCols(first, width);
    shapes->put(first, panel(parts.interior, Eigen::all) - static_part.combination(panel(parts.boundary, Eigen::all)));
  });
  shapes->put(count, responses);
  return shapes;
}

// Rubin's space without its residual flexibility, whose columns would cancel against the modes (see the header):
//   1. free modes Phi and the constraint modes Psi of the held interior;
//   2. of a free component also the interior's answer to the inertia of the rigid-body motions that the boundary
//      causes;
//   3. Phi - Psi Phi_b vanishes on the boundary; orthonormalised and uncoupled it takes the place of fixed-interface
//      modes.
Space rubin_space(const LinearModel& model, const Partition& parts, const SelectedModes& kept) {
  const StiffnessFactor factored = factor_stiffness(parts.stiffness_ii, parts.mass_ii, parts.interior_names);
  const MatrixXd& free_modes = kept.modes.vectors;
  const MatrixXd rigid =
      free_modes.leftCols(kept.rigid) * caused_by_boundary(free_modes(parts.boundary, Eigen::seqN(0, kept.rigid)));
  const MatrixXd inertia = model.mass * rigid;

  const MatrixXd held_rigid_modes = rigid_body_modes(parts, factored);
  const InteriorStatics statics(parts, factored, held_rigid_modes);
  const MatrixXd responses = unit_columns(statics.response(inertia(parts.interior, Eigen::all)), parts.mass_ii);
  Space space{.static_part = statics.constraint_modes(), .factor_bytes = factored.factor.bytes()};
  space.solves = space.static_part->capacity() + rigid.cols();
  space.modes = held_shapes(parts, *space.static_part, free_modes, responses);
  // Twice, as the first pass leaves the smallest of them orthogonal to few digits only.
  for (int pass = 0; pass < 2; ++pass)
    orthonormalise(*space.modes, VectorXd::Ones(space.modes->capacity()), parts.mass_ii);
  space.values = uncouple(*space.modes, parts.stiffness_ii, parts.mass_ii);
  for (Index i = 0; i < space.values.size() && moves_rigidly(parts.stiffness_ii, space.modes->columns(i, i + 1)); ++i)
    space.values[i] = 0.0;
  return space;
}

std::vector<std::string> with_modes(std::vector<std::string> names, Index modes) {
  for (Index i = 1; i <= modes; ++i) names.push_back("mode" + std::to_string(i));
  return names;
}

/// MacNeal's stiffness in [boundary; free modes], and these coordinates' motion in Rubin's.
struct MasslessResidual {
  MatrixXd stiffness, transformation;
};

// MacNeal's form is found inside Rubin's small model, not in the full one: its kept modes are the same, and its further
// modes carry exactly the residual flexibility. G_r is inverted by its principal directions, scaled to a unit diagonal.
/// In Rubin's coordinates the kept modes are exact, and the further ones hold exactly the residual flexibility.
std::optional<MasslessResidual> massless_residual(const LinearModel& rubin, Index n_b, const VectorXd& kept) {
  const Index k = kept.size(), further = rubin.size() - k;
  if (further < n_b) return {};
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> all(MatrixXd(rubin.stiffness), MatrixXd(rubin.mass));
  const MatrixXd modes = all.eigenvectors().leftCols(k), rest = all.eigenvectors().rightCols(further);
  const MatrixXd residual =  // Psi_r
      rest * all.eigenvalues().tail(further).cwiseInverse().asDiagonal() * rest.topRows(n_b).transpose();
  const MatrixXd flexibility = symmetric(residual.topRows(n_b));
  const VectorXd scale = flexibility.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> principal(scale.asDiagonal() * flexibility * scale.asDiagonal());
  if (!scale.allFinite() || (n_b > 0 && !(principal.eigenvalues()[0] > no_flexibility))) return {};
  const MatrixXd root = principal.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal() *
                        principal.eigenvectors().transpose() * scale.asDiagonal();
  MatrixXd boundary(n_b, n_b + k);  // its residual displacement, u_b - Phi_b p
  boundary << MatrixXd::Identity(n_b, n_b), -modes.topRows(n_b);
  const MatrixXd force = root.transpose() * (root * boundary);
  MasslessResidual result{boundary.transpose() * force, residual * force};
  result.stiffness = symmetric(result.stiffness);
  result.stiffness.diagonal().tail(k) += kept;
  result.transformation.rightCols(k) += modes;
  return result;
}

/// Exchanges Rubin's coordinates for MacNeal's; false where no flexibility is left for them.
bool to_macneal(const std::vector<std::string>& names, const VectorXd& kept, Superelement& element) {
  const auto n_b = static_cast<Index>(names.size());
  const auto residual = massless_residual(element.model, n_b, kept);
  if (!residual) return false;
  const MatrixXd& T = residual->transformation;
  LinearModel macneal;
  macneal.stiffness = residual->stiffness.sparseView();
  VectorXd masses = VectorXd::Zero(n_b + kept.size());
  masses.tail(kept.size()).setOnes();
  macneal.mass = MatrixXd(masses.asDiagonal()).sparseView();
  macneal.damping = symmetric(T.transpose() * (element.model.damping * T)).sparseView();
  carry_over(element.model, T, with_modes(names, kept.size()), macneal);
  element.model = std::move(macneal);
  element.basis = element.basis * T;
  return true;
}

}  // namespace

Superelement free_interface(const LinearModel& model, const std::vector<std::string>& boundary,
                            const FreeInterfaceOptions& options) {
  const Stopwatch watch;
  require_free_modes(options.modes);
  const std::vector<std::string> names = joined(boundary, options.also_kept);
  const Partition parts = partition(model, names);
  const FreeModes free = free_modes(model, options.modes, options.whole.get());
  const SelectedModes& kept = free.selected;
  const Space space = rubin_space(model, parts, kept);

  Superelement element;
  element.error_indicators.static_error = static_error(parts, *space.static_part);
  const auto T = transformation(parts, {space.static_part.get(), space.modes.get()});
  element.model = projected_model(model, *T, space.values);
  element.boundary = parts.boundary;
  element.basis = T->take();
  carry_over(model, element.basis, with_modes(names, space.values.size()), element.model);
  ReductionErrorIndicators& error_indicators = element.error_indicators;
  error_indicators.reason = kept.reason + ", and the residual flexibility and mass of the boundary";
  if (options.kind == FreeInterfaceKind::macneal)
    error_indicators.reason =
        to_macneal(names, kept.modes.values, element)
            ? kept.reason + ", and the residual flexibility of the boundary without its mass"
            : error_indicators.reason + " (too few modes are left out for MacNeal's form to exist)";
  error_indicators.fixed_interface_frequencies = natural_frequencies(kept.modes.values);
  error_indicators.highest_kept =
      kept.modes.values.size() > 0 ? error_indicators.fixed_interface_frequencies.tail(1)[0] : 0.0;
  error_indicators.next_left_out = natural_frequencies(VectorXd::Constant(1, kept.modes.next.value_or(0.0)))[0];
  error_indicators.rigid_modes = kept.rigid;
  error_indicators.factor_bytes = std::max(free.factor_bytes, space.factor_bytes);
  error_indicators.solves = kept.modes.solves + space.solves;
  error_indicators.seconds = watch.seconds();
  if (options.error_indicators)
    compare_modes(model, options.compare_up_to, options.full_modes, options.whole.get(), element);
  return element;
}

}  // namespace kalfem
