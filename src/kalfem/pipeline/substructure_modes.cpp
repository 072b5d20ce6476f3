#include "kalfem/pipeline/substructure_modes.hpp"

#include "kalfem/model/modal_damping.hpp"

namespace kalfem {

std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count) {
  std::vector<SubstructureModes> all;
  for (const auto& lumped : study.structure->parts.substructures) {
    if (lumped.masses.empty()) continue;
    const LinearModel model = assemble(lumped);
    const auto modes = normal_modes(model.mass, model.stiffness);
    all.push_back({lumped.name, model.size(), model.mass.sum(), modes.frequencies, modes.shapes});
  }
  for (const auto& elements : study.structure->finite_elements) {
    const auto& part = *elements.part;
    const auto modes = lowest_normal_modes(part.full, count);
    all.push_back({part.name, part.full.size(), part.mass.mass, modes.frequencies, modes.shapes});
  }
  return all;
}

}  // namespace kalfem
