#include <cmath>

#include "kalfem/formats/abaqus/fields.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/regions.hpp"

namespace kalfem::abaqus {

namespace {

/// Cells whose axes agree to about 1e-6.
using AxesKey = std::array<long, 9>;
AxesKey key_of(const Eigen::Matrix3d& axes) {
  AxesKey key;
  for (Index i = 0; i < 9; ++i) key[static_cast<std::size_t>(i)] = std::lround(axes.data()[i] * 1e6);
  return key;
}

}  // namespace

void add_solid_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model) {
  const Keyword& keyword = draft.section.block->keyword;
  const Elastic* material = materials.find(keyword.get("MATERIAL"), keyword.where);
  if (keyword.has("COMPOSITE"))
    deck.problems.add(keyword.where, "the solids '" + draft.name + "' are composite", "layered solids are not read",
                      "use a layer of solids a ply, or shells");
  if (!material) return;
  if (material->isotropic) {
    const std::string name = free_region_name(model, draft.name);
    model.mesh.regions[name] = draft.cells;
    model.properties[name] = SolidProperty{material->name, draft.kind};
    return;
  }
  if (!material->solid) {
    deck.problems.add(keyword.where, "the solids '" + draft.name + "' have the lamina '" + material->name + "'",
                      "a lamina has no stiffness across its thickness", "give engineering constants");
    return;
  }
  LocalAxes axes;
  if (!keyword.get("ORIENTATION").empty())
    axes = orientation_axes(deck, keyword.get("ORIENTATION"), draft.section.place, keyword.where);
  std::map<AxesKey, std::size_t> group_of;
  std::vector<std::vector<Index>> groups;
  std::vector<Matrix6> stiffness;
  for (const Index cell : draft.cells) {
    const Eigen::Matrix3d local = axes.at(centre_of(model.mesh, cell));
    const auto [place, is_new] = group_of.try_emplace(key_of(local), groups.size());
    if (is_new) {
      groups.emplace_back();
      stiffness.push_back(in_global_axes(*material->solid, local));
    }
    groups[place->second].push_back(cell);
  }
  int number = 1;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    std::string name = draft.name;
    do {
      name = number == 1 ? draft.name : draft.name + "." + std::to_string(number);
      ++number;
    } while (model.mesh.regions.contains(name));
    model.mesh.regions[name] = std::move(groups[i]);
    model.properties[name] = SolidProperty{material->name, draft.kind, stiffness[i]};
  }
}

}  // namespace kalfem::abaqus
