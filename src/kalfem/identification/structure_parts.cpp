#include "kalfem/identification/structure_parts.hpp"

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
  return {std::move(assembled), parts.connectors, parts.inputs, parts.damping};
}

}  // namespace kalfem
