// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/active_loads.hpp"

#include <algorithm>

namespace kalfem::abaqus {

void ActiveLoads::add_pressure(Index element, const std::string& face, bool by_surface, const LoadedFace& loaded,
                               double value) {
  auto& pressed = faces_[{element, face, by_surface && of_abaqus_}];
  pressed.face = loaded;
  add(pressed.entry, value);
}

void ActiveLoads::add_body(BodyLoad load) {
  load.step = step_;
  const auto same = [&](const BodyLoad& other, bool any_direction) {
    return other.kind == load.kind && other.set == load.set &&
           (any_direction || ((other.direction - load.direction).norm() < 1e-12 && other.about == load.about));
  };
  if (of_abaqus_) std::erase_if(bodies_, [&](const auto& other) { return other.step != step_ && same(other, true); });
  const auto known = std::ranges::find_if(bodies_, [&](const auto& other) { return same(other, false); });
  if (known == bodies_.end()) {
    bodies_.push_back(std::move(load));
    return;
  }
  if (known->step == step_) load.value += known->value;
  *known = std::move(load);
}

void ActiveLoads::remove_distributed(bool by_surface) {
  if (!of_abaqus_) {
    faces_.clear();
    bodies_.clear();
    return;
  }
  std::erase_if(faces_, [&](const auto& each) { return std::get<2>(each.first) == by_surface; });
  if (!by_surface) bodies_.clear();
}

std::map<NodalDof, double> ActiveLoads::forces() const {
  std::map<NodalDof, double> forces;
  for (const auto& [dof, entry] : forces_)
    if (entry.value != 0.0) forces.emplace(dof, entry.value);
  return forces;
}

std::vector<SurfacePressure> ActiveLoads::pressures() const {
  std::map<double, SurfacePressure> by_value;
  for (const auto& [key, pressed] : faces_) {
    if (pressed.entry.value == 0.0) continue;
    auto& pressure = by_value[pressed.entry.value];
    pressure.pressure = pressed.entry.value;
    pressure.faces.push_back(pressed.face);
  }
  std::vector<SurfacePressure> pressures;
  for (auto& [value, pressure] : by_value) pressures.push_back(std::move(pressure));
  return pressures;
}

}  // namespace kalfem::abaqus
