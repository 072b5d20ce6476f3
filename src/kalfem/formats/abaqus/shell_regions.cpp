// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "kalfem/formats/abaqus/elements.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Makes the property of one section of shells.
class ShellRegion {
public:
  ShellRegion(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model)
      : deck_(deck), materials_(materials), draft_(draft), model_(model), block_(*draft.section.block) {}

  std::optional<RegionProperty> property();

private:
  std::optional<RegionProperty> homogeneous();
  std::optional<RegionProperty> membrane();
  std::optional<RegionProperty> composite();
  std::optional<RegionProperty> direct_stiffness();
  std::optional<double> thickness();
  double offset_ratio();
  std::optional<Ply> ply(const DataLine& line);
  std::optional<double> ply_angle(const DataLine& line);
  void set_shear(LaminateProperty& laminate);
  std::vector<Eigen::Vector3d> directions();
  std::optional<LocalAxes> section_axes();
  double added_mass() { return number_parameter(block_.keyword, "DENSITY", deck_.problems).value_or(0.0); }
  const Where& where() const { return block_.keyword.where; }

  PlacedDeck& deck_;
  Materials& materials_;
  const RegionDraft& draft_;
  FiniteElementModel& model_;
  const Block& block_;
};

std::optional<RegionProperty> ShellRegion::property() {
  try {
    if (draft_.family == Family::membrane) return membrane();
    if (block_.keyword.has("COMPOSITE")) return composite();
    if (block_.keyword.name == "SHELLGENERALSECTION" && block_.keyword.get("MATERIAL").empty())
      return direct_stiffness();
    return homogeneous();
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues()) deck_.problems.add(where(), issue.what, issue.why, issue.fix);
    return {};
  }
}

std::optional<double> ShellRegion::thickness() {
  // Where nodes have their own thickness, the section may do without.
  if (block_.lines.empty() && block_.keyword.has("NODALTHICKNESS")) return 1.0;
  const auto value = number_at(line_of(block_, 0), 0, "a thickness", deck_.problems);
  if (block_.lines.empty())
    deck_.problems.add(where(), block_.keyword.title + " has no thickness", "", "add a data line");
  return value;
}

/// Reference surface above the middle by so many thicknesses.
double ShellRegion::offset_ratio() {
  const std::string text = block_.keyword.word("OFFSET");
  if (text.empty() || text == "MID") return 0.0;
  if (text == "SPOS") return 0.5;
  if (text == "SNEG") return -0.5;
  const auto value = to_number(text);
  if (!value)
    deck_.problems.add(where(), "OFFSET=" + to_string(text) + " is not read", "it must be a number, SPOS or SNEG",
                       "write the offset as a fraction of the thickness");
  return value.value_or(0.0);
}

// An isotropic shell keeps E, density and thickness as parameters. Other materials become a laminate of one ply,
// whose stiffness is fixed. The deck's offset is that of the reference surface from the middle, so the middle lies at
// -ratio t.
std::optional<RegionProperty> ShellRegion::homogeneous() {
  const Elastic* material = materials_.find(block_.keyword.get("MATERIAL"), where());
  const auto t = thickness();
  if (!material || !t) return {};
  const double ratio = offset_ratio();
  if (material->isotropic && !block_.option("TRANSVERSESHEARSTIFFNESS"))
    return ShellProperty{material->name, *t, -ratio * *t, added_mass()};
  if (!material->sheet) {
    deck_.problems.add(where(),
                       "the shells '" + draft_.name + "' have the anisotropic material '" + material->name + "'",
                       "shells need isotropic, orthotropic or lamina materials", "give engineering constants");
    return {};
  }
  auto laminate = laminated({{*material->sheet, *t, 0.0}}, -0.5 * *t - ratio * *t);
  laminate.mass += added_mass();
  laminate.directions = directions();
  set_shear(laminate);
  return laminate;
}

// A membrane is a plate section with a membrane part alone; plate_section() adds a small bending stiffness, so that
// no motion is free.
std::optional<RegionProperty> ShellRegion::membrane() {
  const Elastic* material = materials_.find(block_.keyword.get("MATERIAL"), where());
  const auto t = number_at(line_of(block_, 0), 0, "a thickness", deck_.problems);
  if (!material || !t) return {};
  if (!material->sheet) {
    deck_.problems.add(where(), "the membranes '" + draft_.name + "' have an anisotropic material", "", "");
    return {};
  }
  SeparatePlate plate;
  plate.membrane = material->sheet;
  plate.thickness = *t;
  auto laminate = plate_section(plate);
  laminate.directions = directions();
  return laminate;
}

/// Layers from the bottom up: thickness, points of integration, material, orientation.
std::optional<RegionProperty> ShellRegion::composite() {
  std::vector<Ply> plies;
  double total = 0.0;
  for (const auto& line : block_.lines) {
    const auto next = ply(line);
    if (!next) return {};
    plies.push_back(*next);
    total += next->thickness;
  }
  if (block_.keyword.has("SYMMETRIC")) {
    for (std::size_t i = plies.size(); i-- > 0;) plies.push_back(Ply(plies[i]));
    total *= 2.0;
  }
  auto laminate = laminated(plies, -0.5 * total - offset_ratio() * total);
  laminate.mass += added_mass();
  laminate.directions = directions();
  set_shear(laminate);
  return laminate;
}

std::optional<Ply> ShellRegion::ply(const DataLine& line) {
  const auto t = number_at(line, 0, "the thickness of a layer", deck_.problems);
  // Without a material of its own a layer has that of the section.
  const std::string name = line.field(2).empty() ? block_.keyword.get("MATERIAL") : line.field(2);
  const Elastic* material = materials_.find(name, line.where);
  const auto angle = ply_angle(line);
  if (!t || !material || !angle) return {};
  if (!material->sheet) {
    deck_.problems.add(line.where, "the layer has the anisotropic material '" + material->name + "'",
                       "layers need isotropic, orthotropic or lamina materials", "");
    return {};
  }
  OrthotropicSheet sheet = *material->sheet;
  sheet.density = material->scalar.density;
  return Ply{sheet, *t, *angle};
}

/// Degrees, or an orientation whose angle to the section's direction must be the same in all cells.
std::optional<double> ShellRegion::ply_angle(const DataLine& line) {
  const std::string& text = line.field(3);
  if (text.empty()) return 0.0;
  if (const auto value = to_number(text)) return degree * *value;
  const LocalAxes axes = orientation_axes(deck_, text, draft_.section.place, line.where);
  const auto own = section_axes();
  std::optional<double> angle;
  for (const Index cell : draft_.cells) {
    const Eigen::Vector3d normal = normal_of(model_.mesh, cell), place = centre_of(model_.mesh, cell);
    const Eigen::Vector3d x = own ? shell_direction(*own, place, normal) : shell_direction(normal);
    const Eigen::Vector3d laid = shell_direction(axes, place, normal);
    const double here = std::atan2(normal.dot(x.cross(laid)), x.dot(laid));
    if (angle && std::abs(std::remainder(here - *angle, std::numbers::pi)) > 1e-3) {
      deck_.problems.add(line.where,
                         "the orientation '" + to_string(text) + "' of a layer varies from element to element",
                         "a layer needs one angle to the section's direction", "give the section the ORIENTATION too");
      return {};
    }
    if (!angle) angle = here;
  }
  return angle.value_or(0.0);
}

// If no transverse shear stiffness follows, an estimate by the membrane stiffness is used: (D11 + D22) / 6 + D33 / 3.
/// 21 entries of the symmetric 6 x 6 stiffness, upper triangle by columns.
std::optional<RegionProperty> ShellRegion::direct_stiffness() {
  const auto values = all_numbers(block_.lines, "a section stiffness", deck_.problems);
  if (values.size() < 21) {
    deck_.problems.add(where(), "*SHELL GENERAL SECTION has " + std::to_string(values.size()) + " stiffnesses",
                       "the upper triangle of the 6 x 6 matrix has 21", "give 21, or MATERIAL= and a thickness");
    return {};
  }
  if (values.size() > 21)
    deck_.problems.add(where(), "*SHELL GENERAL SECTION has data behind its 21 stiffnesses",
                       "forces, factors by temperature and others are not read", "remove them");
  Matrix6 d;
  std::size_t next = 0;
  for (Index column = 0; column < 6; ++column)
    for (Index row = 0; row <= column; ++row) d(row, column) = d(column, row) = values[next++];
  LaminateProperty laminate;
  laminate.stiffness.membrane = d.topLeftCorner<3, 3>();
  laminate.stiffness.coupling = d.topRightCorner<3, 3>();
  laminate.stiffness.bending = d.bottomRightCorner<3, 3>();
  laminate.stiffness.shear =
      (d(0, 0) + d(1, 1)) / 6.0 * Eigen::Matrix2d::Identity() + d(2, 2) / 3.0 * Eigen::Matrix2d::Identity();
  laminate.mass = added_mass();
  laminate.directions = directions();
  set_shear(laminate);
  return laminate;
}

/// *TRANSVERSE SHEAR STIFFNESS: K11, K22, K12.
void ShellRegion::set_shear(LaminateProperty& laminate) {
  const Block* given = block_.option("TRANSVERSESHEARSTIFFNESS");
  if (!given) return;
  const auto& line = line_of(*given, 0);
  const double k11 = number_or(line, 0, 0.0, "a shear stiffness", deck_.problems);
  const double k22 = number_or(line, 1, k11, "a shear stiffness", deck_.problems);
  const double k12 = number_or(line, 2, 0.0, "a shear stiffness", deck_.problems);
  laminate.stiffness.shear << k11, k12, k12, k22;
}

std::optional<LocalAxes> ShellRegion::section_axes() {
  const std::string name = block_.keyword.get("ORIENTATION");
  if (name.empty()) return {};
  return orientation_axes(deck_, name, draft_.section.place, where());
}

// The direction 1 of each cell: that of the ORIENTATION laid into the surface, or Abaqus's default, the projection of
// the global x axis. One direction is kept where all are equal.
std::vector<Eigen::Vector3d> ShellRegion::directions() {
  const auto axes = section_axes();
  std::vector<Eigen::Vector3d> result;
  result.reserve(draft_.cells.size());
  bool same = true;
  for (const Index cell : draft_.cells) {
    const Eigen::Vector3d normal = normal_of(model_.mesh, cell);
    result.push_back(axes ? shell_direction(*axes, centre_of(model_.mesh, cell), normal) : shell_direction(normal));
    same = same && (result.back() - result.front()).norm() < 1e-9;
  }
  if (same && !result.empty()) result.resize(1);
  return result;
}

/// *NODAL THICKNESS by node, 0 where none is given.
std::vector<double> thickness_of_nodes(PlacedDeck& deck) {
  std::vector<double> at_node(static_cast<std::size_t>(deck.mesh.node_count()), 0.0);
  for (const auto& given : deck.blocks("NODALTHICKNESS"))
    for (const auto& line : given.block->lines)
      if (const auto value = number_at(line, 1, "a thickness", deck.problems))
        for (const Index node : deck.node_list({line.field(0), line.where}, given.place))
          at_node[static_cast<std::size_t>(node)] = *value;
  return at_node;
}

/// Mean over the nodes of a cell that have a thickness, 0 where none has.
double mean_thickness(const Mesh& mesh, Index cell, const std::vector<double>& at_node) {
  double sum = 0.0;
  int count = 0;
  for (const Index node : mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)]))
    if (const double value = at_node[static_cast<std::size_t>(node)]; value > 0.0) {
      sum += value;
      ++count;
    }
  return count > 0 ? sum / count : 0.0;
}

/// Cells of about the same thickness, to 2 %, share a region that has their mean; the offset keeps its share.
void split_by_thickness(FiniteElementModel& model, const std::string& region, const std::vector<double>& at_node) {
  struct Group {
    std::vector<Index> cells;
    double sum = 0.0;
  };
  const auto whole = std::get<ShellProperty>(model.properties.at(region));
  std::map<long, Group> groups;
  for (const Index cell : model.mesh.regions.at(region)) {
    double thickness = mean_thickness(model.mesh, cell, at_node);
    if (!(thickness > 0.0)) thickness = whole.thickness;
    auto& group = groups[std::lround(std::log(thickness) / std::log(1.02))];
    group.cells.push_back(cell);
    group.sum += thickness;
  }
  model.mesh.regions.erase(region);
  model.properties.erase(region);
  for (auto& [step, group] : groups) {
    ShellProperty part = whole;
    part.thickness = group.sum / static_cast<double>(group.cells.size());
    part.offset = whole.offset * part.thickness / whole.thickness;
    const std::string name = free_region_name(model, region);
    model.mesh.regions[name] = std::move(group.cells);
    model.properties[name] = part;
  }
}

}  // namespace

void add_shell_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model) {
  if (const auto property = ShellRegion(deck, materials, draft, model).property()) {
    const std::string name = free_region_name(model, draft.name);
    model.mesh.regions[name] = draft.cells;
    model.properties[name] = *property;
    if (draft.section.block->keyword.has("NODALTHICKNESS")) deck.regions_by_nodes.push_back(name);
  }
}

void apply_nodal_thickness(PlacedDeck& deck, FiniteElementModel& model) {
  if (deck.regions_by_nodes.empty()) return;
  const auto at_node = thickness_of_nodes(deck);
  for (const auto& region : deck.regions_by_nodes) {
    const bool plain = std::holds_alternative<ShellProperty>(model.properties.at(region));
    deck.notes.add(deck.problems.location({}), "NODAL THICKNESS of '" + region + "'",
                   plain ? "each element takes the mean of its nodes, rounded to steps of 2 %"
                         : "ignored: the thickness of the section is used",
                   DeckNoteKind::changed, model.mesh.regions.at(region).size());
    if (plain) split_by_thickness(model, region, at_node);
  }
}

}  // namespace kalfem::abaqus
