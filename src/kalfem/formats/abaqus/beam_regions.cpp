// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/elements.hpp"
#include "kalfem/formats/abaqus/ledger_sweep.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

using Releases = std::map<Index, std::array<bool, 12>>;  ///< by position among the elements

/// *RELEASE: element or set, end S1 or S2, moments M1, M2, T. Axis 1 of the deck is local z, axis 2 is local -y.
Releases read_releases(PlacedDeck& deck) {
  Releases releases;
  for (const auto& at : deck.blocks("RELEASE"))
    for (const auto& line : at.block->lines) {
      const std::string end = upper_case(line.field(1)), moments = upper_case(line.field(2));
      const std::size_t first = end == "S2" ? 6 : 0;
      if ((end != "S1" && end != "S2") || moments.empty()) {
        deck.problems.add(line.where, "the line cannot be read",
                          "*RELEASE takes an element, S1 or S2, and M1, M2, T or ALLM", "correct the line");
        continue;
      }
      const bool all = moments == "ALLM";
      for (const Index element : deck.element_list({line.field(0), line.where}, at.place)) {
        auto& released = releases[element];
        released[first + 3] = released[first + 3] || all || moments.find('T') != std::string::npos;
        released[first + 4] = released[first + 4] || all || moments.find("M2") != std::string::npos;
        released[first + 5] = released[first + 5] || all || moments.find("M1") != std::string::npos;
      }
    }
  return releases;
}

std::span<const DataLine> first_line(const Block& block) {
  return std::span(block.lines).first(std::min<std::size_t>(1, block.lines.size()));
}

/// A beam section's profile, material and lines.
struct BeamData {
  BeamProfile profile;
  std::string material;
  Eigen::Vector3d n1 = -Eigen::Vector3d::UnitZ();
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< of the section, from the node
};

// A general section may state E and G itself: it becomes a material of its own with nu = E / (2 G) - 1.
std::string make_own_material(const Block& block, const DataLine& moduli, const std::string& region,
                              BeamProfile& profile, PlacedDeck& deck, FiniteElementModel& model) {
  const auto e = number_at(moduli, 0, "Young's modulus", deck.problems);
  if (!e) return {};
  IsotropicMaterial material{*e, 0.0, number_parameter(block.keyword, "DENSITY", deck.problems).value_or(0.0)};
  const double g = number_or(moduli, 1, *e / 2.0, "the shear modulus", deck.problems);
  material.poissons_ratio = g > 0.0 ? *e / (2.0 * g) - 1.0 : 0.0;
  if (!(material.poissons_ratio > -0.99 && material.poissons_ratio < 0.49)) {
    // No solid has that pair of moduli: the section takes up the ratio of the shear moduli.
    material.poissons_ratio = 0.3;
    const double ratio = g / material.shear_modulus();
    profile.torsion *= ratio;
    profile.shear_1 *= ratio;
    profile.shear_2 *= ratio;
  }
  const std::string name = region + ".material";
  model.materials[name] = material;
  return name;
}

// Keyword by keyword: dimensions to a profile, material (or the moduli of the general section itself), direction n1
// turned with the instance, then what options say otherwise: centroid, shear centre, offset, transverse shear
// stiffness.
std::optional<BeamData> beam_data(PlacedDeck& deck, Materials& materials, const RegionDraft& draft,
                                  FiniteElementModel& model) {
  const Block& block = *draft.section.block;
  const bool is_general = block.keyword.name == "BEAMGENERALSECTION";
  std::string shape = block.keyword.word("SECTION");
  if (shape.empty()) shape = is_general ? "GENERAL" : "";
  const auto numbers = all_numbers(first_line(block), "a dimension of the section", deck.problems);

  BeamData data;
  double nu = 0.3;
  if (!is_general || block.lines.size() < 3) {
    const Elastic* material = materials.find(block.keyword.get("MATERIAL"), block.keyword.where);
    if (!material) return {};
    if (!material->isotropic)
      deck.notes.add(deck.problems.location(block.keyword.where), "beams of the material '" + material->name + "'",
                     "Young's modulus along axis 1 and Poisson's ratio 0.3 are used", DeckNoteKind::changed,
                     draft.elements.size());
    data.material = material->name;
    nu = material->scalar.poissons_ratio;
  } else if (const auto e = to_number(line_of(block, 2).field(0)), g = to_number(line_of(block, 2).field(1));
             e && g && *g > 0.0) {
    nu = *e / (2.0 * *g) - 1.0;
  }
  const auto profile = beam_profile(shape, numbers, nu, block.keyword.where, deck.problems);
  if (!profile) return {};
  forget_from(line_of(block, 0), profile_numbers(shape));
  data.profile = *profile;
  if (shape == "L")
    deck.notes.add(deck.problems.location(block.keyword.where), "SECTION=L",
                   "the nodes are assumed where the centre lines of its legs meet", DeckNoteKind::doubtful,
                   draft.elements.size());
  if (const auto& line = line_of(block, 1);
      std::ranges::any_of(line.fields, [](const auto& f) { return !f.empty(); })) {
    for (std::size_t i = 0; i < 3; ++i)
      data.n1[static_cast<Index>(i)] = number_or(line, i, 0.0, "a direction", deck.problems);
    if (data.n1.norm() == 0.0) data.n1 = -Eigen::Vector3d::UnitZ();
  }
  data.n1 = deck.place(draft.section.place).motion.linear() * data.n1.normalized();

  const auto pair_of = [&](const char* option) -> std::optional<Eigen::Vector2d> {
    const Block* given = block.option(option);
    if (!given) return {};
    return Eigen::Vector2d(number_or(line_of(*given, 0), 0, 0.0, "a distance", deck.problems),
                           number_or(line_of(*given, 0), 1, 0.0, "a distance", deck.problems));
  };
  if (const auto centroid = pair_of("CENTROID")) data.profile.centroid = *centroid;
  if (const auto centre = pair_of("SHEARCENTER")) data.profile.shear_centre = *centre;
  if (const auto offset = pair_of("BEAMSECTIONOFFSET")) data.origin = *offset;
  // CalculiX: the reference line lies above the middle by a share of the width.
  if (numbers.size() >= 1)
    data.origin.x() -= number_parameter(block.keyword, "OFFSET1", deck.problems).value_or(0.0) * numbers[0];
  if (numbers.size() >= 2)
    data.origin.y() -= number_parameter(block.keyword, "OFFSET2", deck.problems).value_or(0.0) * numbers[1];
  if (const Block* shear = block.option("TRANSVERSESHEARSTIFFNESS")) {
    const double modulus = data.material.empty()
                               ? number_or(line_of(block, 2), 1, 0.0, "the shear modulus", deck.problems)
                               : materials.find(data.material, block.keyword.where)->scalar.shear_modulus();
    const double k23 = number_or(line_of(*shear, 0), 0, 0.0, "a shear stiffness", deck.problems);
    const double k13 = number_or(line_of(*shear, 0), 1, k23, "a shear stiffness", deck.problems);
    if (modulus > 0.0 && k13 > 0.0 && k23 > 0.0) {
      data.profile.shear_1 = k13 / (modulus * data.profile.area);
      data.profile.shear_2 = k23 / (modulus * data.profile.area);
    }
  }
  if (draft.shear_rigid) data.profile.shear_1 = data.profile.shear_2 = 0.0;
  if (data.material.empty())
    data.material = make_own_material(block, line_of(block, 2), draft.name, data.profile, deck, model);
  if (data.material.empty()) return {};
  return data;
}

/// Axis 1 near a beam's direction shows nothing; another direction is taken.
Eigen::Vector3d usable_n1(PlacedDeck& deck, const BeamData& data, const Eigen::Vector3d& n1,
                          const Eigen::Vector3d& tangent, const Where& where) {
  if (tangent.cross(n1).norm() > 1e-3 * n1.norm()) return n1;
  const auto& p = data.profile;
  const bool even = std::abs(p.i11 - p.i22) < 1e-6 * p.i11 && std::abs(p.i12) < 1e-6 * p.i11;
  if (!even)
    deck.notes.add(deck.problems.location(where), "direction 1 along the beam itself",
                   "y, or x for beams along y, is used as their direction 1", DeckNoteKind::doubtful);
  return std::abs(tangent.y()) < 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
}

}  // namespace

// The beam's line is its shear centre, which the offset moves off the nodes; n1 and the tangent give the local axes.
// One placement serves all cells where they agree.
void add_beam_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model) {
  const auto data = beam_data(deck, materials, draft, model);
  if (!data) return;
  const Releases releases = read_releases(deck);
  BeamProperty property{data->material, section_of(data->profile)};
  const Eigen::Vector2d line = data->origin + data->profile.shear_centre;
  property.placements.clear();
  property.placements.reserve(draft.cells.size());
  bool same = true;
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < draft.cells.size(); ++i) {
    const auto& element = deck.elements[static_cast<std::size_t>(draft.elements[i])];
    deck.nodes_of(element, nodes);
    const bool extra = element.raw->extra_node >= 0;
    const Index first = nodes.front(), last = nodes[static_cast<std::size_t>(deck.type_of(element).nodes - 1)];
    const Eigen::Vector3d along = deck.mesh.nodes.col(last) - deck.mesh.nodes.col(first);
    const Eigen::Vector3d tangent = along.norm() > 0.0 ? Eigen::Vector3d(along.normalized()) : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d given =
        extra ? Eigen::Vector3d(deck.mesh.nodes.col(nodes.back()) - deck.mesh.nodes.col(first)) : data->n1;
    BeamPlacement placement;
    placement.up = usable_n1(deck, *data, given, tangent, element.raw->where);
    if (!line.isZero()) {
      const Eigen::Vector3d n2 = tangent.cross(placement.up).normalized(), n1 = n2.cross(tangent);
      placement.offsets.colwise() = Eigen::Vector3d(line.x() * n1 + line.y() * n2);
    }
    if (const auto hinge = releases.find(draft.elements[i]); hinge != releases.end())
      placement.released = hinge->second;
    same = same && (i == 0 || (placement.up == property.placements.front().up &&
                               placement.offsets == property.placements.front().offsets &&
                               placement.released == property.placements.front().released));
    property.placements.push_back(placement);
  }
  if (same && property.placements.size() > 1) property.placements.resize(1);
  const std::string name = free_region_name(model, draft.name);
  model.mesh.regions[name] = draft.cells;
  model.properties[name] = std::move(property);
}

// A truss has no stiffness across its axis and no rotations: a spring E A / L along it and half its mass at each end.
void add_trusses(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model) {
  const Block& block = *draft.section.block;
  const Elastic* material = materials.find(block.keyword.get("MATERIAL"), block.keyword.where);
  double area = 0.0;
  if (block.keyword.name == "SOLIDSECTION") {
    area = number_or(line_of(block, 0), 0, 1.0, "the area of the trusses", deck.problems);
  } else {
    const auto numbers = all_numbers(first_line(block), "a dimension", deck.problems);
    const std::string shape = block.keyword.word("SECTION");
    const auto profile = beam_profile(shape, numbers, 0.3, block.keyword.where, deck.problems);
    if (!profile) return;
    forget_from(line_of(block, 0), profile_numbers(shape));
    area = profile->area;
  }
  if (!material) return;
  if (!(area > 0.0)) {
    deck.problems.add(block.keyword.where, "the trusses '" + draft.name + "' have the area " + std::to_string(area),
                      "an area must be > 0", "correct the data line");
    return;
  }
  std::vector<Index> nodes;
  std::map<Index, double> lumped;
  for (const Index index : draft.elements) {
    const auto& element = deck.elements[static_cast<std::size_t>(index)];
    if (!deck.nodes_of(element, nodes)) continue;
    for (std::size_t part = 0; part + 1 < nodes.size(); ++part) {
      const Eigen::Vector3d along = deck.mesh.nodes.col(nodes[part + 1]) - deck.mesh.nodes.col(nodes[part]);
      const double length = along.norm();
      if (!(length > 0.0)) {
        deck.problems.add(element.raw->where, "the truss " + deck.element_name(element) + " has no length",
                          "its two nodes coincide", "correct them");
        continue;
      }
      JointSpring joint{.is_bar = true};
      joint.name = draft.name + "." + deck.element_name(element) + (nodes.size() > 2 ? (part == 0 ? "a" : "b") : "");
      for (int a = 0; a < 3; ++a) {
        if (along[a] == 0.0) continue;
        joint.deformation.push_back({{nodes[part + 1], a}, along[a] / length});
        joint.deformation.push_back({{nodes[part], a}, -along[a] / length});
      }
      joint.stiffness = material->scalar.youngs_modulus * area / length;
      model.joints.push_back(std::move(joint));
      for (const std::size_t end : {part, part + 1}) {
        const double volume = 0.5 * area * length, mass = material->scalar.density * volume;
        lumped[nodes[end]] += mass;
        deck.element_masses.push_back({index, nodes[end], mass, volume});
      }
    }
  }
  for (const auto& [node, mass] : lumped)
    if (mass > 0.0)
      model.masses.push_back(
          {draft.name + ".n" + std::to_string(deck.mesh.node_ids[static_cast<std::size_t>(node)]), node, mass});
  deck.notes.add(
      deck.problems.location(block.keyword.where), "trusses",
      "springs along their axes and masses at their nodes take their place, which is exact for small motions",
      DeckNoteKind::unused, draft.elements.size());
}

}  // namespace kalfem::abaqus
