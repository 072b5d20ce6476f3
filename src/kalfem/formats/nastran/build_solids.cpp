// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {
namespace {

using Order = std::vector<std::size_t>;

/// Nodes of the card in the order of CellShape: the card lists the middles between both faces before the far ones.
const Order& middle_order(CellShape corners) {
  static const Order tetrahedron = {4, 5, 6, 7, 8, 9};
  static const Order wedge = {6, 7, 8, 12, 13, 14, 9, 10, 11};
  static const Order hexahedron = {8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15};
  return corners == CellShape::tetrahedron4 ? tetrahedron : corners == CellShape::wedge6 ? wedge : hexahedron;
}

CellShape quadratic(CellShape corners) {
  return corners == CellShape::tetrahedron4 ? CellShape::tetrahedron10
         : corners == CellShape::wedge6     ? CellShape::wedge15
                                            : CellShape::hexahedron20;
}

/// Order that turns the element inside out: both faces the other way round.
Order mirrored(CellShape shape) {
  switch (shape) {
    case CellShape::tetrahedron4:
      return {0, 2, 1, 3};
    case CellShape::tetrahedron10:
      return {0, 2, 1, 3, 6, 5, 4, 7, 9, 8};
    case CellShape::wedge6:
      return {0, 2, 1, 3, 5, 4};
    case CellShape::wedge15:
      return {0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13};
    case CellShape::hexahedron8:
      return {0, 3, 2, 1, 4, 7, 6, 5};
    default:
      return {0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17};
  }
}

class SolidBuilder {
public:
  SolidBuilder(Building& building, Materials& materials) : building_(building), materials_(materials) {}
  void add(const SolidCard& card);

private:
  bool make_region(const SolidCard& card, const PsolidCard& solid, const std::string& region, const std::string& title);
  void add_cell(CellShape shape, Id id, std::vector<Eigen::Index> nodes, const std::string& region);
  std::vector<Eigen::Index> indices(const SolidCard& card, std::size_t count, const std::string& title);

  Building& building_;
  Materials& materials_;
  std::map<std::string, bool> sound_;
};

// With MAT9 the elasticity is turned from the material axes (CORDM) to the global ones: C' = R^T C R with
// the local strains R e of global strains e. All elements of a property share it, so axes that vary over the mesh are
// taken at the origin of their system.
bool SolidBuilder::make_region(const SolidCard& card, const PsolidCard& solid, const std::string& region,
                               const std::string& title) {
  const MaterialCard* material = materials_.find(solid.material, title, card.where);
  if (material == nullptr) return false;
  SolidProperty property;
  if (const auto* law = std::get_if<Material9>(&material->law)) {
    const Frame* frame =
        solid.axes > 0 ? building_.frames.find(solid.axes, card.where) : building_.frames.find(0, card.where);
    if (frame == nullptr) return false;
    if (solid.axes < 0 || frame->kind != SystemKind::rectangular)
      building_.note(card.where, "CORDM of a PSOLID with MAT9 that varies from element to element",
                     "its stiffness uses the axes at the origin of the system", DeckNoteKind::changed);
    property.elasticity = in_global_axes(law->stiffness, frame->axes);
    property.material = "mat" + std::to_string(solid.material);
    // E and nu of the material serve no element then; the mean stiffness keeps its place.
    building_.model.materials[property.material] = {law->stiffness.topLeftCorner<3, 3>().diagonal().mean(), 0.3,
                                                    law->density * building_.bulk.mass_factor};
  } else {
    property.material = materials_.isotropic(solid.material, title, card.where);
    if (property.material.empty()) return false;
  }
  building_.model.properties[region] = property;
  return true;
}

// All nodes of a card, or none where one is missing: that is a problem already.
std::vector<Eigen::Index> SolidBuilder::indices(const SolidCard& card, std::size_t count, const std::string& title) {
  std::vector<Eigen::Index> nodes(count);
  for (std::size_t i = 0; i < count; ++i)
    if ((nodes[i] = building_.node(card.nodes[i], title, card.where)) < 0) return {};
  return nodes;
}

void SolidBuilder::add(const SolidCard& card) {
  const auto title = "solid " + std::to_string(card.id);
  const auto* solid = find_law<PsolidCard>(building_, card.property, title, card.where);
  if (solid == nullptr) return;
  const auto region = "psolid" + std::to_string(card.property);
  const auto [sound, is_new] = sound_.try_emplace(region, false);
  if (is_new) sound->second = make_region(card, *solid, region, title);
  if (!sound->second) return;
  // A pyramid is cut along the diagonal 1-3 of its base into two tetrahedra; both keep the number of the element.
  if (card.pyramid) {
    const auto nodes = indices(card, 5, title);
    if (nodes.empty()) return;
    if (std::any_of(card.nodes.begin() + 5, card.nodes.end(), [](Id node) { return node != 0; }))
      building_.note(card.where, "CPYRAM with midside nodes", "the midside nodes are not connected to it",
                     DeckNoteKind::changed);
    building_.note(card.where, "CPYRAM", "each is replaced by two tetrahedra between its corners",
                   DeckNoteKind::changed);
    add_cell(CellShape::tetrahedron4, card.id, {nodes[0], nodes[1], nodes[2], nodes[4]}, region);
    add_cell(CellShape::tetrahedron4, card.id, {nodes[0], nodes[2], nodes[3], nodes[4]}, region);
    return;
  }
  const auto corners = static_cast<std::size_t>(node_count(card.shape));
  const auto& order = middle_order(card.shape);
  std::size_t middles = 0;
  for (const auto i : order) middles += card.nodes[i] != 0 ? 1 : 0;
  const bool full = middles == order.size();
  if (middles > 0 && !full)
    building_.note(card.where, "solids with some of their midside nodes",
                   "they are read by their corners only; the midside nodes are not connected to them",
                   DeckNoteKind::changed);
  const auto nodes = indices(card, full ? corners + order.size() : corners, title);
  if (nodes.empty()) return;
  std::vector<Eigen::Index> ordered(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(corners));
  if (full)
    for (const auto i : order) ordered.push_back(nodes[i]);
  add_cell(full ? quadratic(card.shape) : card.shape, card.id, std::move(ordered), region);
}

/// The far side, or apex, lies on the side of the first face from which its nodes run counter-clockwise.
void SolidBuilder::add_cell(CellShape shape, Id id, std::vector<Eigen::Index> nodes, const std::string& region) {
  const auto place = [&](std::size_t i) { return building_.place(nodes[i]); };
  const std::size_t across = shape == CellShape::hexahedron8 || shape == CellShape::hexahedron20 ? 3 : 2;
  const std::size_t above = across == 3 ? 4 : 3;
  const Eigen::Vector3d normal = across == 3 ? Eigen::Vector3d((place(2) - place(0)).cross(place(3) - place(1)))
                                             : Eigen::Vector3d((place(1) - place(0)).cross(place(2) - place(0)));
  if (normal.dot(place(above) - place(0)) < 0.0) {
    const auto as_given = nodes;
    const auto order = mirrored(shape);
    for (std::size_t i = 0; i < order.size(); ++i) nodes[i] = as_given[order[i]];
  }
  auto& mesh = building_.model.mesh;
  mesh.regions[region].push_back(mesh.add_cell(shape, id, nodes));
}

}  // namespace

void build_solids(Building& building, Materials& materials) {
  SolidBuilder builder(building, materials);
  for (const auto& card : building.bulk.solids) builder.add(card);
}

}  // namespace kalfem::nastran
