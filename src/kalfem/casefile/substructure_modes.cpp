#include "kalfem/casefile/substructure_modes.hpp"

#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {
namespace {

NormalModes lowest_normal_modes(const LinearModel& model, Eigen::Index count) {
  const auto& damped = model.modal_damping.modes;
  if (damped.frequencies.size() >= count) return {damped.frequencies.head(count), damped.shapes.leftCols(count)};
  const auto lowest = lowest_modes(model.stiffness, model.mass, {.count = std::min(count, model.size())});
  return {lowest.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi), lowest.vectors};
}

}  // namespace

std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count) {
  std::vector<SubstructureModes> all;
  for (const auto& lumped : study.parts.substructures) {
    if (lumped.masses.empty()) continue;
    const LinearModel model = assemble(lumped);
    const auto modes = normal_modes(model.mass, model.stiffness);
    all.push_back({lumped.name, model.size(), model.mass.sum(), modes.frequencies, modes.shapes});
  }
  for (const auto& elements : study.finite_elements) {
    const auto& part = *elements.part;
    const auto modes = lowest_normal_modes(part.full, count);
    all.push_back({part.name, part.full.size(), part.mass.mass, modes.frequencies, modes.shapes});
  }
  return all;
}

}  // namespace kalfem
