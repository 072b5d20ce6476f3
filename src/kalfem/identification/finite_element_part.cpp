#include "kalfem/identification/finite_element_part.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
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
  switch (method) {
    case ReductionMethod::guyan:
      return guyan(full, boundary, options);
    case ReductionMethod::rubin:
      return free_interface(full, boundary, {.kind = FreeInterfaceKind::rubin, .modes = options.modes});
    case ReductionMethod::macneal:
      return free_interface(full, boundary, {.kind = FreeInterfaceKind::macneal, .modes = options.modes});
    case ReductionMethod::craig_bampton:
      break;
  }
  return craig_bampton(full, boundary, options);
}

// Where the units are in doubt they are told first: constraints and springs in wrong units look like mechanisms.
void require_no_mechanism(const FiniteElementModel& elements, const AssembledModel& assembled) {
  const auto free = find_mechanisms(elements, assembled);
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

void require_stable(const FiniteElementPart& part) try {
  SparseFactor(evaluate(part.assembled.stiffness, part.assembled.parameters));
} catch (const NotPositiveDefinite&) {
  throw InvalidInput("the preload of '" + part.name + "' is beyond its buckling load or critical speed",
                     "its stiffness under this load is not positive definite", "reduce the load or add supports");
}

}  // namespace

void assemble_part(FiniteElementPart& part, const AssemblyOptions& options) {
  require_connected(part.elements);
  part.assembled = assemble(part.elements, options);
  if (part.preload_stiffness.size() > 0) {
    add_preload(part.preload_stiffness, part.assembled);
    require_stable(part);
  }
  if (!part.elements.mesh.cells.empty()) require_no_mechanism(part.elements, part.assembled);
  part.mass = mass_properties(part.assembled);
  part.moving_mass = moving_mass(part.elements, part.assembled);
  part.full = linear_model(part.elements, part.assembled, part.nodes, part.damping.rayleigh);
  part.full.points_only = true;
}

Superelement reduce(const FiniteElementPart& part, const ReductionRequest& request, double sensor_bandwidth) {
  ReductionOptions options{.modes = request.modes, .augmentation_vectors = request.augmentation_vectors};
  if (!options.modes.count && !options.modes.cutoff && !options.modes.effective_mass)
    options.modes.cutoff = 3.0 * (std::isfinite(sensor_bandwidth) ? sensor_bandwidth : default_bandwidth);
  return with_scale(part, reduce_by(request.method, part.full, part.boundary, options));
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
