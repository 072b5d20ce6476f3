#include "kalfem/identification/structure.hpp"

namespace kalfem {
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
