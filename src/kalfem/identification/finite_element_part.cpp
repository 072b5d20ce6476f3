// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/finite_element_part.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/identification/response_reduction.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/hourglass.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/mesh/connectivity.hpp"
#include "kalfem/reduction/free_interface.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Sensors' bandwidth where none of them has a limit [Hz].
constexpr double default_bandwidth = 100.0;

/// The filter's initial deviations and noise are given for displacements; modal coordinates are larger by the root of
/// the mass that moves.
Superelement with_scale(const FiniteElementPart& part, Superelement superelement) {
  auto& model = superelement.model;
  const auto boundary = static_cast<Index>(superelement.boundary.size());
  model.points_only = true;
  model.coordinate_scale = Eigen::VectorXd::Ones(model.size());
  model.coordinate_scale.tail(model.size() - boundary).setConstant(std::sqrt(part.moving_mass.mean()));
  return superelement;
}

Superelement reduce_by(ReductionMethod method, const LinearModel& full, const std::vector<std::string>& boundary,
                       const ReductionOptions& options) {
  FreeInterfaceOptions free{.modes = options.modes, .full_modes = options.full_modes, .whole = options.whole};
  switch (method) {
    case ReductionMethod::guyan:
      return guyan(full, boundary, options);
    case ReductionMethod::rubin:
      return free_interface(full, boundary, free);
    case ReductionMethod::macneal:
      free.kind = FreeInterfaceKind::macneal;
      return free_interface(full, boundary, free);
    case ReductionMethod::craig_bampton:
      break;
  }
  return craig_bampton(full, boundary, options);
}

/// Without a limit of its own: modes up to three times the bandwidth [Hz].
ModeSelection modes_for(const ReductionRequest& request, double bandwidth) {
  ModeSelection modes = request.modes;
  if (!modes.count && !modes.cutoff && !modes.effective_mass) modes.cutoff = 3.0 * bandwidth;
  return modes;
}

// Where the units are in doubt they are told first: constraints and springs in wrong units look like mechanisms.
void require_no_mechanism(const FiniteElementModel& elements, const AssembledModel& assembled,
                          const SparseMatrix& stiffness, bool each_part) {
  const auto free = find_mechanisms(elements, assembled, stiffness, each_part);
  if (free.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(free.size(), 10); ++i) names += (i == 0 ? "" : ", ") + free[i];
  if (free.size() > 10) names += " and " + std::to_string(free.size() - 10) + " more";
  if (const auto units = units_finding(elements))
    throw InvalidInput(
        "substructure '" + elements.name + "': " + units->what, units->why,
        units->fix + "; if the units are right, fix or connect " + names + ", which move without strain");
  const auto [why, fix] = mechanism_reason(elements);
  throw InvalidInput("substructure '" + elements.name + "' is a mechanism: it moves without strain at " + names, why,
                     fix);
}

/// Adds T^T K_g T to the term that no parameter changes.
void add_preload(const SparseMatrix& preload, AssembledModel& assembled) {
  const SparseMatrix own = assembled.expansion.transpose() * preload * assembled.expansion;
  const auto constant = std::ranges::find_if(assembled.stiffness, [](const auto& term) { return term.powers.empty(); });
  if (constant == assembled.stiffness.end())
    assembled.stiffness.push_back({{}, own});
  else
    add_to(constant->matrix, own);
}

void require_stable(const FiniteElementPart& part, const SparseMatrix& stiffness) try {
  SparseFactor{stiffness};
} catch (const NotPositiveDefinite&) {
  throw InvalidInput("the preload of '" + part.name + "' is beyond its buckling load or critical speed",
                     "its stiffness under this load is not positive definite", "reduce the load or add supports");
}

/// The factor of K, which shows at once that the part is neither a mechanism nor beyond its buckling load; where there
/// is none, the cause is looked for.
std::shared_ptr<const StiffnessFactor> checked_factor(const FiniteElementPart& part, const SparseMatrix& stiffness,
                                                      const SparseMatrix& mass, bool each_part) {
  if (part.elements.mesh.cells.empty() && part.preload_stiffness.size() == 0) return nullptr;
  if (auto factor = factor_held(part.elements, part.assembled, stiffness, mass, each_part))
    return std::make_shared<const StiffnessFactor>(std::move(*factor));
  if (part.preload_stiffness.size() > 0) require_stable(part, stiffness);
  if (!part.elements.mesh.cells.empty()) require_no_mechanism(part.elements, part.assembled, stiffness, each_part);
  return nullptr;
}

/// The sum of the terms; where no parameter changes them it takes their place, and they are left empty.
SparseMatrix sum_of(std::vector<AffineTerm>& terms, const AssembledModel& assembled, bool constant) {
  if (!constant) return evaluate(terms, assembled.parameters);
  SparseMatrix sum = std::move(terms.front().matrix);
  terms.clear();
  return sum;
}

}  // namespace

// At the present values K and M exist once, in the full model.
void assemble_part(FiniteElementPart& part, AssemblyOptions options) {
  SparseMatrix stiffness, mass;
  std::vector<Index> joined;
  for (const auto& dof : options.independent) joined.push_back(dof.node);
  bool each_part = false;
  part.times.measure("assemble", [&] {
    each_part = require_connected(part.elements, joined);
    part.assembled = assemble(part.elements, options);
    if (part.assembled.size() == 0)
      throw InvalidInput("nothing of substructure '" + part.name + "' can move",
                         "its supports hold every node that elements, springs or masses act on", "hold fewer nodes");
    if (part.preload_stiffness.size() > 0) add_preload(part.preload_stiffness, part.assembled);
    stiffness = sum_of(part.assembled.stiffness, part.assembled, options.at_present_values);
    mass = sum_of(part.assembled.mass, part.assembled, options.at_present_values);
  });
  part.times.measure("factor", [&] { part.factor = checked_factor(part, stiffness, mass, each_part); });
  part.mass = mass_properties(part.elements, part.assembled, mass);
  part.moving_mass = moving_mass(part.elements, part.assembled, mass);
  part.full = linear_model(part.elements, part.assembled, std::move(stiffness), std::move(mass), part.nodes,
                           part.damping.rayleigh);
  part.full.gauges = gauge_combinations(part.elements, part.assembled, part.gauges);
  part.full.points_only = true;
}

AssembledModel with_terms(const FiniteElementPart& part) {
  AssembledModel assembled = part.assembled;
  if (assembled.stiffness.empty()) assembled.stiffness.push_back({{}, part.full.stiffness});
  if (assembled.mass.empty()) assembled.mass.push_back({{}, part.full.mass});
  return assembled;
}

Superelement reduce(const FiniteElementPart& part, const ReductionRequest& request, double sensor_bandwidth,
                    Index full_modes) {
  const double bandwidth = std::isfinite(sensor_bandwidth) ? sensor_bandwidth : default_bandwidth;
  return with_scale(part, reduce_by(request.method, part.full, part.boundary,
                                    {.modes = modes_for(request, bandwidth),
                                     .augmentation_vectors = request.augmentation_vectors,
                                     .full_modes = full_modes,
                                     .whole = part.factor}));
}

NormalModes lowest_full_modes(const FiniteElementSubstructure& substructure, Index count) {
  const FiniteElementPart& part = *substructure.part;
  const auto known = substructure.reduced ? substructure.reduced->full_modes : nullptr;
  if (known && known->frequencies.size() >= count)
    return {known->frequencies.head(count), known->shapes.leftCols(count)};
  return lowest_normal_modes(part.full, {count}, part.factor.get());
}

Superelement reduce_for_responses(const FiniteElementPart& part, const ReductionRequest& request,
                                  const std::vector<std::string>& loaded, double highest) {
  std::vector<std::string> boundary = part.boundary;
  std::ranges::copy_if(loaded, std::back_inserter(boundary), [&](const std::string& dof) {
    return std::ranges::find(part.boundary, dof) == part.boundary.end();
  });
  return with_scale(part, reduce_by(request.method, part.full, boundary,
                                    {.modes = modes_for(request, highest),
                                     .augmentation_vectors = request.augmentation_vectors,
                                     .error_indicators = false}));
}

Superelement reduce_again(const FiniteElementPart& part, const LinearModel& full, const ReductionRequest& request,
                          const ReductionErrorIndicators& first) {
  return with_scale(part, reduce_by(request.method, full, part.boundary,
                                    {.modes = {.count = first.fixed_interface_frequencies.size()},
                                     .augmentation_vectors = request.augmentation_vectors,
                                     .order = first.order,
                                     .error_indicators = false}));
}

Superelement reduce_up_to(const FiniteElementPart& part, double frequency) {
  return with_scale(
      part, craig_bampton(part.full, part.boundary,
                          {.modes = {.cutoff = frequency}, .augmentation_vectors = true, .error_indicators = false}));
}

}  // namespace kalfem
