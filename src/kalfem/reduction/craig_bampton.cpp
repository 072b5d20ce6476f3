// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/long_products.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/linalg/tall_matrices.hpp"
#include "kalfem/reduction/comparison.hpp"
#include "kalfem/reduction/interior_statics.hpp"
#include "kalfem/reduction/mode_selection.hpp"
#include "kalfem/reduction/projection.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Part of a column's length below which what is left of it is rounding.
constexpr double rounding = 1e-10;

/// K_ii^-1 (M_ii Psi + M_ib), n_i x n_b: what the interior does quasi-statically under the inertia forces of unit
/// boundary accelerations.
std::unique_ptr<LongVectors> inertia_response(const Partition& parts, const SparseMatrix& mass_ib,
                                              const LongVectors& constraint_modes, const SparseFactor& stiffness) {
  auto responses = make_long_vectors(constraint_modes.rows());
  responses->reserve(constraint_modes.capacity());
  SymmetricProduct mass(parts.mass_ii);
  by_panels(constraint_modes.capacity(), widest_panel, [&](Index first, Index width) {
    MatrixXd response = constraint_modes.columns(first, first + width);
    mass.multiply(response, response);
    response += mass_ib.middleCols(first, width);
    stiffness.solve(response, response);
    responses->put(first, response);
  });
  return responses;
}

/// Shapes that make up for the fixed-interface modes Phi that were left out [DNW97]: the inertia response less the kept
/// modes' part of it,
///     X = (1 - Phi Phi^T M_ii) K_ii^-1 (M_ii Psi + M_ib),
/// made mass-normalised and uncoupled, so that they read as further modes (vectors n_i x at most n_b in place of the
/// inertia response, values [(rad/s)^2] above those of the kept modes). Columns that add nothing are dropped: none are
/// left where all modes are kept. What is left of a column may be small, as its part in mode j falls with 1 / lambda_j,
/// and counts all the same.
VectorXd to_augmentation_vectors(const Partition& parts, const LongVectors& kept, LongVectors& shapes) {
  const VectorXd sizes = lengths(shapes, parts.mass_ii);
  for (int pass = 0; pass < 2; ++pass)  // where little is left, the first pass leaves rounding of what was there
    project_out(kept, parts.mass_ii, shapes);
  const VectorXd left = lengths(shapes, parts.mass_ii);
  const VectorXd to_unit_size = (left.array() > rounding * sizes.array()).select(left.cwiseInverse(), 0.0);
  orthonormalise(shapes, to_unit_size, parts.mass_ii);
  project_out(kept, parts.mass_ii, shapes);
  return uncouple(shapes, parts.stiffness_ii, parts.mass_ii);
}

std::vector<std::string> reduced_names(const std::vector<std::string>& boundary, Index modes, Index truncation) {
  std::vector<std::string> names = boundary;
  for (Index i = 1; i <= modes; ++i) names.push_back("mode" + std::to_string(i));
  for (Index i = 1; i <= truncation; ++i) names.push_back("truncation" + std::to_string(i));
  return names;
}

/// An order for the interior that fills little: the given one, or that of the whole without the boundary.
EliminationOrder order_for(const Partition& parts, const ReductionOptions& options) {
  if (!options.order.empty() || !options.whole) return options.order;
  std::vector<Index> places(parts.interior.size() + parts.boundary.size(), -1);
  for (std::size_t i = 0; i < parts.interior.size(); ++i)
    places[static_cast<std::size_t>(parts.interior[i])] = static_cast<Index>(i);
  EliminationOrder order;
  for (const auto row : options.whole->factor.order())
    if (const Index place = places[static_cast<std::size_t>(row)]; place >= 0) order.push_back(place);
  return order;
}

/// All that K_ii is solved for; its factor, in memory larger than the rest of a reduction, ends with it.
struct InteriorSolutions {
  SelectedModes kept;                                  ///< whose vectors are the next member's
  std::unique_ptr<LongVectors> fixed_interface_modes;  ///< Phi, n_i x m
  std::unique_ptr<LongVectors> constraint_modes;       ///< Psi, n_i x n_b
  std::unique_ptr<LongVectors> inertia_response;       ///< n_i x n_b; none where no augmentation vectors are wanted
  double factor_bytes = 0.0;
  EliminationOrder order;
};

/// The modes come first: the space in which they are looked for is the largest beside the factors.
InteriorSolutions solve_interior(const LinearModel& model, const Partition& parts,
                                 const std::vector<std::string>& names, const ReductionOptions& options) {
  const StiffnessFactor factored =
      factor_stiffness(parts.stiffness_ii, parts.mass_ii, parts.interior_names, order_for(parts, options));
  const MatrixXd rigid_modes = rigid_body_modes(parts, factored);
  InteriorSolutions solutions{.factor_bytes = factored.factor.bytes(), .order = factored.factor.order()};
  const MatrixXd following =
      options.modes.effective_mass
          ? InteriorStatics(parts, factored, rigid_modes).response(-parts.stiffness_ib * translations(names))
          : MatrixXd();
  solutions.kept = select_modes(parts, following, factored, options.modes);
  solutions.fixed_interface_modes = make_long_vectors(std::move(solutions.kept.modes.vectors));
  solutions.constraint_modes = InteriorStatics(parts, factored, rigid_modes).constraint_modes();
  solutions.inertia_response = options.augmentation_vectors
                                   ? inertia_response(parts, select(model.mass, parts.interior, parts.boundary),
                                                      *solutions.constraint_modes, factored.factor)
                                   : make_long_vectors(parts.stiffness_ii.rows());
  return solutions;
}

// Craig and Bampton [CB68], with the interior i and the boundary b:
//   1. factor K_ii + shift M_ii, in the whole model's order where that is known; a free interior has rigid-body modes,
//      which the constraint modes leave out;
//   2. fixed-interface modes K_ii Phi = M_ii Phi Lambda, as many as the options ask for;
//   3. constraint modes Psi = -K_ii^-1 K_ib;
//   4. modal truncation augmentation vectors [DNW97] behind them, where they are wanted;
//   5. project on T = [Psi Phi; 1 0].
// The shapes are long vectors until the superelement takes T.
/// The superelement without its comparison with the full model; what belongs to the interior alone ends here.
Superelement reduced(const LinearModel& model, const std::vector<std::string>& names, const ReductionOptions& options) {
  const Partition parts = partition(model, names);
  InteriorSolutions solved = solve_interior(model, parts, names, options);
  const VectorXd kept = natural_frequencies(solved.kept.modes.values);

  Superelement element;
  ReductionErrorIndicators& error_indicators = element.error_indicators;
  error_indicators.static_error = static_error(parts, *solved.constraint_modes);
  error_indicators.fixed_interface_frequencies = kept;
  error_indicators.highest_kept = kept.size() > 0 ? kept.tail(1)[0] : 0.0;
  error_indicators.next_left_out = natural_frequencies(VectorXd::Constant(1, solved.kept.modes.next.value_or(0.0)))[0];
  error_indicators.rigid_modes = solved.kept.rigid;
  error_indicators.reason = solved.kept.reason;
  error_indicators.factor_bytes = solved.factor_bytes;
  error_indicators.order = std::move(solved.order);
  error_indicators.solves = solved.kept.modes.solves + solved.constraint_modes->capacity();

  const VectorXd further = to_augmentation_vectors(parts, *solved.fixed_interface_modes, *solved.inertia_response);
  if (further.size() > 0)
    error_indicators.reason += ", " + std::to_string(further.size()) + " modal truncation augmentation vectors";
  VectorXd values(kept.size() + further.size());
  values << solved.kept.modes.values, further;
  const auto T = transformation(
      parts, {solved.constraint_modes.get(), solved.fixed_interface_modes.get(), solved.inertia_response.get()});
  element.model = projected_model(model, *T, values);
  element.boundary = parts.boundary;
  element.basis = T->take();
  carry_over(model, element.basis, reduced_names(names, kept.size(), further.size()), element.model);
  return element;
}

}  // namespace

Superelement craig_bampton(const LinearModel& model, const std::vector<std::string>& boundary,
                           const ReductionOptions& options) {
  const Stopwatch watch;
  Superelement element = reduced(model, joined(boundary, options.also_kept), options);
  element.error_indicators.seconds = watch.seconds();
  if (options.error_indicators)
    compare_modes(model, options.compare_up_to, options.full_modes, options.whole.get(), element);
  return element;
}

Superelement guyan(const LinearModel& model, const std::vector<std::string>& boundary,
                   const ReductionOptions& options) {
  ReductionOptions without_modes = options;
  without_modes.modes = {.count = 0};
  return craig_bampton(model, boundary, without_modes);
}

}  // namespace kalfem
