// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/compute.hpp"

#include <algorithm>
#include <set>
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

const SubstructureModes* UpdatedModes::of(const std::string& substructure) const {
  const auto found = std::ranges::find(substructures, substructure, &SubstructureModes::name);
  return found == substructures.end() ? nullptr : &*found;
}

const SubstructureModes* updated_modes_of(const StudyResults& results, const std::string& substructure) {
  const auto* updated = results.find<UpdatedModes>();
  return updated ? updated->of(substructure) : nullptr;
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

UpdatedModes modes_at(const Study& study, const Eigen::VectorXd& values, Eigen::Index count) {
  std::set<std::string> names;
  for (const auto& [index, target] : study.updating->bindings)
    if (!target.of_connector()) names.insert(target.owner);
  UpdatedModes all;
  if (count == 0) return all;
  for (const auto& name : names) {
    const auto parameterised = study.updating_plan->structure->model_of(name);
    if (!parameterised) continue;
    const LinearModel model = parameterised->at(values).model;
    const auto modes = lowest_normal_modes(model, {std::min(count, model.size())});
    all.substructures.push_back({name, model.size(), 0.0, modes.frequencies, modes.shapes});
  }
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
