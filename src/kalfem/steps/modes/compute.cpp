// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/compute.hpp"

#include <utility>

#include "kalfem/model/linear_model.hpp"
#include "kalfem/study/component_parts.hpp"
#include "kalfem/system/linearised.hpp"

namespace kalfem {

const ModesOutcome& modes_found(const StudyResults& results) {
  static const ModesOutcome none;
  const auto* found = results.find<ModesOutcome>();
  return found ? *found : none;
}

std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count) {
  std::vector<SubstructureModes> all;
  for (const auto& lumped : study.structure->parts.substructures) {
    if (lumped.masses.empty()) continue;
    const LinearModel model = assemble(lumped);
    const auto modes = normal_modes(model.mass, model.stiffness);
    all.push_back({lumped.name, model.size(), model.mass.sum(), modes.frequencies, modes.shapes});
  }
  for (const auto& elements : study.structure->finite_elements)
    all.push_back(modes_of(*elements.part, lowest_full_modes(elements, count)));
  return all;
}

Eigen::VectorXd joined_frequencies(const Study& study, Eigen::Index count, std::vector<std::string>& warnings) try {
  const StructureParts& parts = study.structure->parts;
  if (parts.shared.empty() || count == 0) return {};
  return lowest_normal_modes(linearised_at_rest(couple(parts)), {count}).frequencies;
} catch (const InvalidInput& error) {
  warnings.push_back(std::string("the natural frequencies of the joined structure are left out: ") + error.what());
  return {};
}

SubstructureModes modes_of(const FiniteElementPart& part, NormalModes modes) {
  return {part.name, part.full.size(), part.mass.mass, std::move(modes.frequencies), std::move(modes.shapes)};
}

}  // namespace kalfem
