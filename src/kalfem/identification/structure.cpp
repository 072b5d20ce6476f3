// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/structure.hpp"

namespace kalfem {

std::vector<std::string> ground_names(const StructureParts& parts) {
  std::vector<std::string> names;
  for (const auto& part : parts.substructures)
    for (const auto& ground : part.grounds) names.push_back(part.name + "." + ground);
  for (const auto& part : parts.finite_elements)
    for (const auto& ground : part.model->grounds) names.push_back(part.name + "." + ground.ground);
  return names;
}

CoupledModel couple(const StructureParts& parts) {
  std::vector<Substructure> assembled;
  for (const auto& part : parts.substructures) assembled.push_back({part.name, assemble(part)});
  assembled.insert(assembled.end(), parts.finite_elements.begin(), parts.finite_elements.end());
  return {std::move(assembled), parts.connectors, parts.inputs, parts.damping, parts.shared};
}

namespace {

/// The reduced model if there is one, otherwise the full one.
Substructure model_of(const FiniteElementPartPtr& part, const std::shared_ptr<const Superelement>& reduced) {
  using ModelPtr = std::shared_ptr<const LinearModel>;
  return {part->name, reduced ? ModelPtr(reduced, &reduced->model) : ModelPtr(part, &part->full)};
}

}  // namespace

std::vector<Substructure> StructureModel::reduced_parts() const {
  std::vector<Substructure> reduced;
  for (const auto& each : finite_elements) reduced.push_back(model_of(each.part, each.reduced));
  return reduced;
}

StructureParts StructureModel::reference_parts() const {
  StructureParts reference = parts;
  reference.finite_elements.clear();
  for (const auto& each : finite_elements) reference.finite_elements.push_back(model_of(each.part, each.reference));
  return reference;
}

}  // namespace kalfem
