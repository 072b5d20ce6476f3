// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/body_forces.hpp"

#include <algorithm>

#include "kalfem/model/statics/rotation.hpp"

namespace kalfem::abaqus {

namespace {

/// Those of `each` that belong to the kept cells; one for all stays.
template <typename Item>
void keep(std::vector<Item>& each, const std::vector<std::size_t>& kept) {
  if (each.size() <= 1) return;
  std::vector<Item> left;
  for (const std::size_t i : kept) left.push_back(each[i]);
  each = std::move(left);
}

/// The model with some of its cells alone: no supports, links, springs and masses.
FiniteElementModel with_cells(const FiniteElementModel& model, const std::vector<bool>& wanted) {
  FiniteElementModel part;
  part.name = model.name;
  part.mesh = model.mesh;
  part.mesh.regions.clear();
  part.materials = model.materials;
  for (const auto& [region, property] : model.properties) {
    std::vector<Index> cells;
    std::vector<std::size_t> kept;
    const auto& all = model.mesh.regions.at(region);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (wanted[static_cast<std::size_t>(all[i])]) {
        cells.push_back(all[i]);
        kept.push_back(i);
      }
    if (cells.empty()) continue;
    RegionProperty own = property;
    if (auto* beams = std::get_if<BeamProperty>(&own)) keep(beams->placements, kept);
    if (auto* laminate = std::get_if<LaminateProperty>(&own)) keep(laminate->directions, kept);
    part.mesh.regions[region] = std::move(cells);
    part.properties[region] = std::move(own);
  }
  return part;
}

/// Density 1 and no other mass; false where a laminate does not tell its volume.
bool weigh_volume(FiniteElementModel& model) {
  for (auto& [name, material] : model.materials) material.density = 1.0;
  for (auto& [region, property] : model.properties) {
    if (std::holds_alternative<LaminateProperty>(property)) return false;
    if (auto* shell = std::get_if<ShellProperty>(&property)) shell->nonstructural_mass = 0.0;
    if (auto* beam = std::get_if<BeamProperty>(&property)) beam->nonstructural_mass = 0.0;
  }
  return true;
}

std::vector<bool> flags(const std::vector<Index>& members, std::size_t size) {
  std::vector<bool> is_member(size, false);
  for (const Index member : members) is_member[static_cast<std::size_t>(member)] = true;
  return is_member;
}

}  // namespace

bool are_all_masses(const PlacedDeck& deck, const std::vector<Index>& elements) {
  if (deck.has_matrices()) return false;
  const auto loaded = flags(elements, deck.elements.size());
  for (std::size_t i = 0; i < deck.elements.size(); ++i)
    if (deck.elements[i].cell >= 0 && !loaded[i]) return false;
  for (const auto& mass : deck.element_masses)
    if (!loaded[static_cast<std::size_t>(mass.element)]) return false;
  return true;
}

std::optional<Eigen::VectorXd> field_forces(PlacedDeck& deck, const FiniteElementModel& model,
                                            const std::vector<Index>& elements, const AccelerationField& field,
                                            bool per_volume, const Where& where) {
  const auto refuse = [&](const std::string& what) -> std::optional<Eigen::VectorXd> {
    deck.problems.add(where, "a load on a part of the model acts on " + what, "its forces on these cannot be found",
                      "name a set of all elements, or give forces at nodes");
    return {};
  };
  const auto loaded = flags(elements, deck.elements.size());
  std::vector<bool> cells(model.mesh.cells.size(), false);
  for (const Index element : elements) {
    const auto& placed = deck.elements[static_cast<std::size_t>(element)];
    if (placed.cell < 0) continue;
    const auto& type = deck.type_of(placed);
    if (type.family != Family::solid && node_count(type.shape) != corner_count(type.shape))
      return refuse("elements of type " + deck.type_name(placed));
    cells[static_cast<std::size_t>(placed.cell)] = true;
  }
  FiniteElementModel part = with_cells(model, cells);
  const auto is_loaded = [&](const auto& mass) { return loaded[static_cast<std::size_t>(mass.element)]; };
  if (part.properties.empty() && std::ranges::none_of(deck.element_masses, is_loaded)) {
    deck.problems.add(where, "a load on a part of the model acts on springs or other elements without mass",
                      "gravity, rotation and forces per volume act on masses", "name elements that have mass");
    return {};
  }
  if (per_volume && !weigh_volume(part)) return refuse("composite or orthotropic shells");
  Eigen::VectorXd forces = part.properties.empty() ? Eigen::VectorXd(Eigen::VectorXd::Zero(6 * model.mesh.node_count()))
                                                   : kalfem::field_forces(part, field);
  for (const auto& mass : deck.element_masses) {
    if (!is_loaded(mass)) continue;
    if (mass.by_direction) return refuse("a *MASS, TYPE=ANISOTROPIC");
    forces.segment<3>(6 * mass.node) +=
        (per_volume ? mass.volume : mass.mass) * field.at(model.mesh.nodes.col(mass.node));
  }
  return forces;
}

}  // namespace kalfem::abaqus
