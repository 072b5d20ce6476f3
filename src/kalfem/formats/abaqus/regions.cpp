// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/elements.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Whether a section keyword gives properties to elements of a family.
bool fits(const std::string& keyword, Family family) {
  if (keyword == "SHELLSECTION" || keyword == "SHELLGENERALSECTION") return family == Family::shell;
  if (keyword == "MEMBRANESECTION") return family == Family::membrane;
  if (keyword == "SOLIDSECTION")
    return family == Family::solid || family == Family::truss || family == Family::membrane;
  return family == Family::beam || family == Family::truss;  // CalculiX gives trusses beam sections
}

const char* section_for(Family family) {
  switch (family) {
    case Family::shell:
      return "*SHELL SECTION";
    case Family::membrane:
      return "*MEMBRANE SECTION";
    case Family::beam:
      return "*BEAM SECTION";
    default:
      return "*SOLID SECTION";
  }
}

/// Sections in their order; of those over the same element the last one holds.
std::vector<PlacedBlock> assign_sections(PlacedDeck& deck) {
  static const std::set<std::string, std::less<>> keywords = {
      "SHELLSECTION", "SHELLGENERALSECTION", "MEMBRANESECTION", "SOLIDSECTION", "BEAMSECTION", "BEAMGENERALSECTION"};
  std::vector<PlacedBlock> sections;
  for (int place = 0; place < deck.place_count(); ++place)
    for (const Scope* scope : deck.place(place).scopes)
      for (const auto& block : scope->blocks)
        if (keywords.contains(block.keyword.name)) sections.push_back({&block, place});
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const Keyword& keyword = sections[i].block->keyword;
    if (keyword.get("ELSET").empty()) {
      deck.problems.add(keyword.where, keyword.title + " has no ELSET", "ELSET must name its elements",
                        "give ELSET=<name>");
      continue;
    }
    for (const Index index : deck.element_list({keyword.get("ELSET"), keyword.where}, sections[i].place)) {
      auto& element = deck.elements[static_cast<std::size_t>(index)];
      if (!fits(keyword.name, deck.type_of(element).family)) continue;
      if (element.section >= 0)
        deck.notes.add(deck.problems.location(keyword.where), "elements with two sections", "the last section is used",
                       DeckNoteKind::changed);
      element.section = static_cast<int>(i);
    }
  }
  return sections;
}

/// Shape and nodes of the cell: quadrilaterals and hexahedra with a side of no length become triangles and wedges.
CellShape cell_shape(const ElementType& type, std::vector<Index>& nodes) {
  if (type.shape == CellShape::line3) std::swap(nodes[1], nodes[2]);  // the deck has the middle between the ends
  if (type.shape == CellShape::quadrilateral4)
    for (std::size_t i = 0; i < 4; ++i)
      if (nodes[i] == nodes[(i + 1) % 4]) {
        nodes.erase(nodes.begin() + static_cast<std::ptrdiff_t>(i));
        return CellShape::triangle3;
      }
  if (type.shape == CellShape::hexahedron8 && nodes[2] == nodes[3] && nodes[6] == nodes[7]) {
    nodes = {nodes[0], nodes[1], nodes[2], nodes[4], nodes[5], nodes[6]};
    return CellShape::wedge6;
  }
  return type.shape;
}

void report_without_section(PlacedDeck& deck, const PlacedElement& element, std::set<std::string>& told) {
  if (!told.insert(deck.type_name(element)).second) return;
  std::size_t count = 0;
  for (const auto& other : deck.elements)
    if (other.section < 0 && deck.type_name(other) == deck.type_name(element)) ++count;
  deck.problems.add(element.raw->where,
                    std::to_string(count) + " elements of type " + deck.type_name(element) +
                        " have no section; the first is " + deck.element_name(element),
                    "every element needs a section",
                    std::string("add them to the ELSET of a ") + section_for(deck.type_of(element).family));
}

/// How elements of one section are told apart.
struct Variant {
  Family family;
  SolidKind kind;
  bool shear_rigid;
  friend auto operator<=>(const Variant&, const Variant&) = default;
};

/// Abaqus integrates the volume change of C3D8 once for the element, CalculiX does not.
SolidKind kind_in_dialect(const RawDeck& raw, const ElementType& type) {
  if (type.kind != SolidKind::mean_dilatation) return type.kind;
  return raw.from_abaqus ? SolidKind::mean_dilatation : SolidKind::full;
}

/// Tells what is left out of elements, and how those are read that differ between Abaqus and CalculiX, with their
/// number.
void note_types(const RawDeck& raw, PlacedDeck& deck) {
  std::vector<std::pair<std::size_t, Where>> count(raw.types.size());
  for (const auto& element : deck.elements)
    if (auto& [number, where] = count[static_cast<std::size_t>(element.raw->type)]; number++ == 0)
      where = element.raw->where;
  for (std::size_t i = 0; i < count.size(); ++i) {
    const auto& [name, type] = raw.types[i];
    const auto tell = [&](const std::string& consequence, DeckNoteKind kind) {
      if (count[i].first > 0)
        deck.notes.add(deck.problems.location(count[i].second), "element type " + name, consequence, kind,
                       count[i].first);
    };
    if (!type.remark.empty()) tell(type.remark, type.remark_kind);
    if (type.family != Family::solid || type.kind != SolidKind::mean_dilatation) continue;
    tell(raw.from_abaqus ? "read as in Abaqus (one volume change per element), because the deck has Abaqus keywords"
                         : "read as in CalculiX (fully integrated); C3D8I bends without locking",
         DeckNoteKind::changed);
  }
}

}  // namespace

std::string free_region_name(const FiniteElementModel& model, const std::string& name) {
  std::string candidate = name;
  for (int i = 2; model.mesh.regions.contains(candidate); ++i) candidate = name + "." + std::to_string(i);
  return candidate;
}

Eigen::Vector3d centre_of(const Mesh& mesh, Index cell) {
  const auto& item = mesh.cells[static_cast<std::size_t>(cell)];
  const auto nodes = mesh.nodes_of(item).first(static_cast<std::size_t>(corner_count(item.shape)));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Index node : nodes) sum += mesh.nodes.col(node);
  return sum / static_cast<double>(nodes.size());
}

// Half the cross product of the diagonals is the mean normal of a warped quadrilateral.
Eigen::Vector3d normal_of(const Mesh& mesh, Index cell) {
  const auto& item = mesh.cells[static_cast<std::size_t>(cell)];
  const auto nodes = mesh.nodes_of(item);
  const bool four = corner_count(item.shape) == 4;
  const Eigen::Vector3d first = mesh.nodes.col(nodes[four ? 2 : 1]) - mesh.nodes.col(nodes[0]);
  const Eigen::Vector3d second = mesh.nodes.col(nodes[four ? 3 : 2]) - mesh.nodes.col(nodes[four ? 1 : 0]);
  return first.cross(second).normalized();
}

// Elements become cells in drafts of regions, one for each section and each kind of element in it, since these need
// properties of their own. The draft is looked up only where section or type changes from one element to the next. When
// all cells are there, each draft gets its property.
void build_regions(const RawDeck& raw, PlacedDeck& deck, Materials& materials, FiniteElementModel& model) {
  const auto sections = assign_sections(deck);
  note_types(raw, deck);
  Mesh& mesh = model.mesh;
  std::vector<RegionDraft> drafts;
  std::map<std::pair<int, Variant>, std::size_t> draft_of;
  std::set<std::string> told;
  std::vector<Index> nodes;
  mesh.cells.reserve(deck.elements.size());
  int last_section = -1, last_type = -1;
  std::size_t last_draft = 0;
  for (std::size_t i = 0; i < deck.elements.size(); ++i) {
    auto& element = deck.elements[i];
    const auto& type = deck.type_of(element);
    if (!is_cell(type.family) && type.family != Family::truss) continue;
    if (element.section < 0) {
      report_without_section(deck, element, told);
      continue;
    }
    if (element.section != last_section || element.raw->type != last_type) {
      const Variant variant{type.family, type.family == Family::solid ? kind_in_dialect(raw, type) : type.kind,
                            type.shear_rigid};
      const auto [place, is_new] = draft_of.try_emplace({element.section, variant}, drafts.size());
      if (is_new) {
        const auto& section = sections[static_cast<std::size_t>(element.section)];
        drafts.push_back({deck.spelled_set(section.block->keyword.get("ELSET"), section.place, false),
                          section,
                          {},
                          {},
                          variant.family,
                          variant.kind,
                          variant.shear_rigid});
      }
      last_draft = place->second;
      last_section = element.section;
      last_type = element.raw->type;
    }
    auto& draft = drafts[last_draft];
    if (is_cell(type.family)) {
      if (!deck.nodes_of(element, nodes)) continue;
      if (element.raw->extra_node >= 0) nodes.pop_back();
      const CellShape shape = cell_shape(type, nodes);
      element.cell = mesh.add_cell(shape, element.raw->label + deck.place(element.place).raised_by, nodes);
      draft.cells.push_back(element.cell);
    }
    draft.elements.push_back(static_cast<Index>(i));
  }
  for (const auto& draft : drafts) {
    switch (draft.family) {
      case Family::shell:
      case Family::membrane:
        add_shell_region(deck, materials, draft, model);
        break;
      case Family::beam:
        add_beam_region(deck, materials, draft, model);
        break;
      case Family::solid:
        add_solid_region(deck, materials, draft, model);
        break;
      default:
        add_trusses(deck, materials, draft, model);
        break;
    }
    for (const auto& [region, property] : model.properties)
      deck.origins.try_emplace(region, draft.section.block->keyword.where);
  }
}

namespace {

/// Cells whose axes agree to about 1e-6.
using AxesKey = std::array<long, 9>;
AxesKey key_of(const Eigen::Matrix3d& axes) {
  AxesKey key;
  for (Index i = 0; i < 9; ++i) key[static_cast<std::size_t>(i)] = std::lround(axes.data()[i] * 1e6);
  return key;
}

}  // namespace

// An anisotropic material is turned into global axes, which a curved orientation makes differ from cell to cell: cells
// whose axes agree share a region.
void add_solid_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model) {
  const Keyword& keyword = draft.section.block->keyword;
  const Elastic* material = materials.find(keyword.get("MATERIAL"), keyword.where);
  if (keyword.has("COMPOSITE"))
    deck.problems.add(keyword.where, "the solids '" + draft.name + "' are composite",
                      "layered solids are not supported", "use one layer of solids per ply, or shells");
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
