// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {
namespace {

/// Whether a property names one of the materials.
struct NamesOneOf {
  const std::map<Id, Place>& materials;

  bool operator()(const PshellCard& shell) const {
    return has(shell.membrane) || has(shell.bending) || has(shell.shear);
  }
  bool operator()(const PcompCard& laminate) const {
    return std::ranges::any_of(laminate.plies, [&](const PlyCard& ply) { return has(ply.material); });
  }
  bool operator()(const BushProperty&) const { return false; }
  bool operator()(const auto& property) const { return has(property.material); }

  [[nodiscard]] bool has(Id material) const { return materials.contains(material); }
};

}  // namespace

void note_damped_elements(Building& building) {
  const auto& bulk = building.bulk;
  if (bulk.damped_materials.empty()) return;
  const NamesOneOf is_damped{bulk.damped_materials};
  const Place where = bulk.damped_materials.begin()->second;
  const auto tell = [&](bool damped) {
    if (damped)
      building.note(where, "structural damping (GE) of materials", "it is ignored; give modal damping instead",
                    DeckNoteKind::changed);
  };
  std::map<Id, bool> known;
  const auto has_damped_property = [&](Id property) {
    const auto [place, is_new] = known.try_emplace(property, false);
    const auto [first, last] = bulk.properties.equal_range(property);
    if (is_new)
      place->second =
          std::any_of(first, last, [&](const auto& card) { return std::visit(is_damped, card.second.law); });
    return place->second;
  };
  const auto tell_all = [&](const auto& elements) {
    for (const auto& element : elements) tell(has_damped_property(element.property));
  };
  tell_all(bulk.shells);
  tell_all(bulk.shear_panels);
  tell_all(bulk.solids);
  for (const auto& beam : bulk.beams) {
    const auto& defaults = beam.is_bar ? bulk.bar_defaults : bulk.beam_defaults;
    tell(has_damped_property(beam.property > 0 ? beam.property : defaults.property > 0 ? defaults.property : beam.id));
  }
  tell_all(bulk.rods);
  for (const auto& [id, card] : bulk.conrods) tell(std::visit(is_damped, card.law));
}

}  // namespace kalfem::nastran
