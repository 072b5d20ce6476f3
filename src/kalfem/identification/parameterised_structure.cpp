// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameterised_structure.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The bindings of one substructure to its own kind of parameter.
template <class Target>
std::vector<ParameterBinding<Target>> bindings_of(const std::vector<StructureBinding>& all,
                                                  const std::string& substructure) {
  std::vector<ParameterBinding<Target>> own;
  for (const auto& [index, parameter] : all)
    if (const auto* target = std::get_if<Target>(&parameter.where); target && parameter.owner == substructure)
      own.push_back({index, *target});
  return own;
}

/// Ratios of all modes, one per mode. Above their limit they fall as 1 / omega, as in add_modal_damping() for large
/// models. Empty if no mode lies below the limit.
std::vector<double> ratios_of_all(const VectorXd& frequencies, const ModalRatios& ratios) {
  const Index below = (frequencies.array() <= ratios.up_to).count();
  if (below == 0) return {};
  std::vector<double> all;
  for (Index i = 0; i < frequencies.size(); ++i)
    all.push_back(i < below ? ratios.values[std::min(static_cast<std::size_t>(i), ratios.values.size() - 1)]
                            : all[static_cast<std::size_t>(below) - 1] * frequencies[below - 1] / frequencies[i]);
  return all;
}

// Turns modal damping ratios into a matrix: C += sum_i 2 zeta_i omega_i (M phi_i)(M phi_i)^T over the normal modes of
// the model at these parameters.
LinearModel damped(ModelAtParameters at) {
  auto& [model, ratios] = at;
  if (ratios.empty()) return model;
  const NormalModes modes = normal_modes(model.mass, model.stiffness);
  model.damping =
      SparseMatrix(model.damping + modal_damping(model.mass, modes, ratios_of_all(modes.frequencies, ratios)));
  return model;
}

}  // namespace

ParameterisedStructure::ParameterisedStructure(StructurePtr structure, const std::vector<StructureBinding>& bindings,
                                               Index count)
    : structure_(std::move(structure)) {
  for (const auto& part : structure_->parts.substructures)
    lumped_.push_back(
        std::make_shared<const ParameterisedLumped>(part, bindings_of<LumpedParameter>(bindings, part.name), count));
  for (const auto& each : structure_->finite_elements) {
    const auto& part = each.part;
    finite_elements_.push_back(std::make_shared<const ParameterisedFiniteElements>(
        std::shared_ptr<const AssembledModel>(part, &part->assembled),
        std::shared_ptr<const LinearModel>(part, &part->full), part->damping,
        bindings_of<FiniteElementParameter>(bindings, part->name), count));
  }
}

std::shared_ptr<const ParameterisedModel> ParameterisedStructure::model_of(const std::string& substructure) const {
  for (std::size_t i = 0; i < lumped_.size(); ++i)
    if (structure_->parts.substructures[i].name == substructure) return lumped_[i];
  for (std::size_t i = 0; i < finite_elements_.size(); ++i)
    if (structure_->finite_elements[i].part->name == substructure) return finite_elements_[i];
  return nullptr;
}

StructureParts ParameterisedStructure::with_lumped_at(const VectorXd& parameters) const {
  StructureParts parts = structure_->parts;
  for (std::size_t i = 0; i < lumped_.size(); ++i) parts.substructures[i] = lumped_[i]->substructure_at(parameters);
  parts.finite_elements.clear();
  return parts;
}

std::shared_ptr<const ParameterisedModel> ParameterisedStructure::reduced_at(std::size_t index,
                                                                             const VectorXd& parameters) const {
  const auto& elements = structure_->finite_elements[index];
  if (!elements.reduced) return finite_elements_[index];
  const auto reduced = reduce_again(*elements.part, finite_elements_[index]->at(parameters).model, elements.reduction,
                                    elements.reduced->error_indicators);
  return std::make_shared<const ParameterisedFiniteElements>(
      finite_elements_[index]->in_basis(reduced.basis, reduced.model, parameters));
}

// at() reduces the finite elements anew, near() keeps the bases that at() found. So the columns of a Jacobian by
// differences share one basis and contain no change of it.
StructureAtParameters ParameterisedStructure::at(const VectorXd& parameters) const {
  StructureAtParameters structure;
  for (std::size_t i = 0; i < finite_elements_.size(); ++i) structure.in_basis.push_back(reduced_at(i, parameters));
  structure.parts = near(structure, parameters);
  return structure;
}

StructureParts ParameterisedStructure::near(const StructureAtParameters& structure, const VectorXd& parameters) const {
  StructureParts parts = with_lumped_at(parameters);
  for (std::size_t i = 0; i < structure.in_basis.size(); ++i)
    parts.finite_elements.push_back(
        {structure_->finite_elements[i].part->name, damped(structure.in_basis[i]->at(parameters))});
  return parts;
}

}  // namespace kalfem
