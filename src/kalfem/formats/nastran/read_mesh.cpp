// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// More scalar points than this are a mistake.
constexpr std::size_t most_scalar_points = 2'000'000;

void read_grid(const Card& card, const Reading& in) {
  Grid grid;
  grid.id = card.id(1, "ID");
  // Blank fields wait for GRDSET, which may stand behind.
  grid.position_system = card.id_or(2, -2, "CP");
  for (int i = 0; i < 3; ++i) grid.place[i] = card.real_or(static_cast<std::size_t>(3 + i), 0.0, "X");
  grid.motion_system = card.id_or(6, -2, "CD");
  if (grid.motion_system == -1)
    throw CardError(title(card) + ": CD is -1, a fluid point", "fluids are not supported",
                    "remove the fluid from the deck");
  grid.held = card.blank(7) ? ~0u : card.components(7, "PS");
  grid.where = card.place;
  in.bulk.grids.push_back(grid);
}

void read_grdset(const Card& card, const Reading& in) {
  in.bulk.grid_defaults = {card.id_or(2, 0, "CP"), card.id_or(6, 0, "CD"), card.components(7, "PS")};
}

// Scalar points are kept as grid points without a place, so that cards find both in one list. THRU gives ranges.
void read_spoint(const Card& card, const Reading& in) {
  for (const auto& range : card.id_list(1, "ID")) {
    if (static_cast<std::size_t>(range.last - range.first) > most_scalar_points)
      throw CardError(title(card) + ": more than 2 million points", "", "correct the range");
    for (std::int64_t id = range.first; id <= range.last; id += range.step)
      in.bulk.grids.push_back({static_cast<Id>(id), 0, scalar_point, 0, Eigen::Vector3d::Zero(), card.place});
  }
}

void add_system(Id id, SystemCard system, const Card& card, const Reading& in) {
  system.where = card.place;
  if (!in.bulk.systems.try_emplace(id, system).second)
    throw CardError("coordinate system " + std::to_string(id) + " is defined twice", "", "remove one of them");
}

// CORD2 gives the points A, B and C by coordinates in the system RID, CORD1 by grid points. A CORD1 card defines up
// to two systems.
template <SystemKind kind>
void read_cord2(const Card& card, const Reading& in) {
  SystemCard system;
  system.kind = kind;
  system.reference = card.id_or(2, 0, "RID");
  for (int i = 0; i < 9; ++i)
    system.points(i % 3, i / 3) = card.real_or(static_cast<std::size_t>(3 + i), 0.0, "a coordinate of A, B or C");
  add_system(card.id(1, "CID"), system, card, in);
}

template <SystemKind kind>
void read_cord1(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 5}) {
    if (card.blank(first)) continue;
    SystemCard system;
    system.kind = kind;
    system.nodes = {card.id(first + 1, "G1"), card.id(first + 2, "G2"), card.id(first + 3, "G3")};
    add_system(card.id(first, "CID"), system, card, in);
  }
}

constexpr auto node_readers = std::to_array<CardReader>({{"GRID", read_grid},
                                                         {"GRDSET", read_grdset},
                                                         {"SPOINT", read_spoint},
                                                         {"CORD1R", read_cord1<SystemKind::rectangular>},
                                                         {"CORD1C", read_cord1<SystemKind::cylindrical>},
                                                         {"CORD1S", read_cord1<SystemKind::spherical>},
                                                         {"CORD2R", read_cord2<SystemKind::rectangular>},
                                                         {"CORD2C", read_cord2<SystemKind::cylindrical>},
                                                         {"CORD2S", read_cord2<SystemKind::spherical>}});

}  // namespace

std::span<const CardReader> node_cards() { return node_readers; }

namespace {

/// Where the fields of one kind of shell stand on its card.
struct ShellFields {
  bool triangle;
  std::size_t nodes, node_count, corners;
  std::size_t angle, offset, flag, thickness;
};

// Corners are required and midside nodes optional. THETA / MCID is one field: an integer is a material system, a real
// number an angle. A blank PID is the element's number. Corner thicknesses are rare, so they stand in a list of their
// own.
void read_shell(const Card& card, const Reading& in, const ShellFields& fields) {
  ShellCard shell;
  shell.id = card.id(1, "EID");
  shell.property = card.id_or(2, shell.id, "PID");
  shell.triangle = fields.triangle;
  const std::size_t corners = fields.corners;
  for (std::size_t i = 0; i < fields.node_count; ++i)
    shell.nodes[i] =
        i < corners ? card.id(fields.nodes + i, "a grid point") : card.id_or(fields.nodes + i, 0, "a grid point");
  if (card.is_integer(fields.angle))
    shell.material_system = card.id_or(fields.angle, -1, "MCID");
  else
    shell.angle = card.real_or(fields.angle, 0.0, "THETA");
  shell.offset = card.real_or(fields.offset, 0.0, "ZOFFS");
  CornerThickness thickness{{not_given, not_given, not_given, not_given},
                            card.integer_or(fields.flag, 0, "TFLAG") == 1};
  bool any = false;
  for (std::size_t i = 0; i < corners; ++i)
    if (!card.blank(fields.thickness + i)) {
      thickness.values[i] = card.real(fields.thickness + i, "T");
      any = true;
    }
  if (!any && !card.blank(fields.flag))
    in.tell(card, fields.flag, "TFLAG of shells without thicknesses at their corners", "it has no effect",
            DeckNoteKind::unused);
  if (any) {
    shell.thickness = static_cast<std::int32_t>(in.bulk.corner_thickness.size());
    in.bulk.corner_thickness.push_back(thickness);
  }
  shell.where = card.place;
  in.bulk.add_element(ElementKind::structural, shell.id, card.place);
  in.bulk.shells.push_back(shell);
}

void read_quad4(const Card& card, const Reading& in) { read_shell(card, in, {false, 3, 4, 4, 7, 8, 10, 11}); }
void read_quad8(const Card& card, const Reading& in) { read_shell(card, in, {false, 3, 8, 4, 15, 16, 17, 11}); }
void read_tria3(const Card& card, const Reading& in) { read_shell(card, in, {true, 3, 3, 3, 6, 7, 10, 11}); }
void read_tria6(const Card& card, const Reading& in) { read_shell(card, in, {true, 3, 6, 3, 9, 10, 14, 11}); }

void read_shear(const Card& card, const Reading& in) {
  ShearCard panel;
  panel.id = card.id(1, "EID");
  panel.property = card.id_or(2, panel.id, "PID");
  for (std::size_t i = 0; i < 4; ++i) panel.nodes[i] = card.id(3 + i, "a grid point");
  panel.where = card.place;
  in.bulk.add_element(ElementKind::structural, panel.id, card.place);
  in.bulk.shear_panels.push_back(panel);
}

// CHEXA, CPENTA and CTETRA give linear and quadratic elements by one card: nodes behind the corners may be blank.
void read_solid(const Card& card, const Reading& in, CellShape shape, std::size_t corners, std::size_t most,
                bool pyramid = false) {
  SolidCard solid;
  solid.id = card.id(1, "EID");
  solid.property = card.id_or(2, solid.id, "PID");
  solid.shape = shape;
  solid.pyramid = pyramid;
  for (std::size_t i = 0; i < most; ++i)
    solid.nodes[i] = i < corners ? card.id(3 + i, "a grid point") : card.id_or(3 + i, 0, "a grid point");
  solid.where = card.place;
  in.bulk.add_element(ElementKind::structural, solid.id, card.place);
  in.bulk.solids.push_back(solid);
}

void read_hexa(const Card& card, const Reading& in) { read_solid(card, in, CellShape::hexahedron8, 8, 20); }
void read_penta(const Card& card, const Reading& in) { read_solid(card, in, CellShape::wedge6, 6, 15); }
void read_tetra(const Card& card, const Reading& in) { read_solid(card, in, CellShape::tetrahedron4, 4, 10); }
void read_pyramid(const Card& card, const Reading& in) { read_solid(card, in, CellShape::tetrahedron4, 5, 13, true); }

constexpr auto shell_readers = std::to_array<CardReader>({{"CQUAD4", read_quad4},
                                                          {"CSHEAR", read_shear},
                                                          {"CQUADR", read_quad4},
                                                          {"CQUAD8", read_quad8},
                                                          {"CTRIA3", read_tria3},
                                                          {"CTRIAR", read_tria3},
                                                          {"CTRIA6", read_tria6},
                                                          {"CHEXA", read_hexa},
                                                          {"CPENTA", read_penta},
                                                          {"CTETRA", read_tetra},
                                                          {"CPYRAM", read_pyramid},
                                                          {"CPYRA", read_pyramid}});

}  // namespace

std::span<const CardReader> shell_cards() { return shell_readers; }

namespace {

/// Whether a whole number stands where a node or the first component of a vector may stand.
bool names_node(const Card& card, std::size_t i) {
  return card.is_integer(i) && card.blank(i + 1) && card.blank(i + 2);
}

Eigen::Vector3d vector_at(const Card& card, std::size_t first, const char* what) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) vector[static_cast<Eigen::Index>(i)] = card.real_or(first + i, 0.0, what);
  return vector;
}

/// Three letters of OFFT.
std::array<char, 3> offset_axes(const Card& card, std::size_t i, const std::string& otherwise) {
  const auto word = card.blank(i) || card.is_number(i) ? otherwise : card.text(i);
  if (word.size() != 3 || word.find_first_not_of("GBOE") != std::string::npos || word[0] == 'O' || word[0] == 'E')
    throw CardError(title(card) + ": OFFT is '" + word + "'", "it must be three letters such as GGG, BGG or GOO",
                    "correct the field");
  return {word[0], word[1], word[2]};
}

// Defaults of BAROR and BEAMOR for CBAR and CBEAM: property, orientation and axes of offsets.
BeamDefaults read_defaults(const Card& card) {
  BeamDefaults defaults;
  defaults.property = card.id_or(2, 0, "PID");
  if (names_node(card, 5))
    defaults.orientation_node = card.id(5, "G0");
  else if (!card.blank(5) || !card.blank(6) || !card.blank(7))
    defaults.orientation = vector_at(card, 5, "X");
  const auto axes = offset_axes(card, 8, "GGG");
  defaults.axes.assign(axes.begin(), axes.end());
  return defaults;
}

void read_baror(const Card& card, const Reading& in) { in.bulk.bar_defaults = read_defaults(card); }
void read_beamor(const Card& card, const Reading& in) { in.bulk.beam_defaults = read_defaults(card); }

/// BAROR and BEAMOR may stand behind: what they fill in is marked by 0 and by '?'.
void read_beam(const Card& card, const Reading& in) {
  BeamCard beam;
  beam.id = card.id(1, "EID");
  beam.property = card.id_or(2, 0, "PID");
  beam.nodes = {card.id(3, "GA"), card.id(4, "GB")};
  if (names_node(card, 5))
    beam.orientation_node = card.id(5, "G0");
  else
    beam.orientation = vector_at(card, 5, "X");
  // A number there is BIT, the twist of beams of higher order.
  const bool has_axes = !card.blank(8) && !card.is_number(8);
  beam.axes = has_axes ? offset_axes(card, 8, "GGG") : std::array{'?', '?', '?'};
  beam.pins = {card.components(9, "PA"), card.components(10, "PB")};
  beam.offsets.col(0) = vector_at(card, 11, "WA");
  beam.offsets.col(1) = vector_at(card, 14, "WB");
  beam.is_bar = card.name == "CBAR";
  beam.where = card.place;
  for (const std::size_t i : {17, 18})
    if (!beam.is_bar && !card.blank(i))
      in.tell(card, i, "warping (SA, SB of CBEAM)",
              "torsion follows St Venant; the stiffness of restrained warping is ignored", DeckNoteKind::changed);
  in.bulk.add_element(ElementKind::structural, beam.id, card.place);
  in.bulk.beams.push_back(beam);
}

void add_rod(const Card& card, const Reading& in, const char* kind, Id property, std::size_t nodes) {
  RodCard rod;
  rod.id = card.id(1, "EID");
  rod.kind = kind;
  rod.property = property;
  rod.nodes = {card.id(nodes, "G1"), card.id(nodes + 1, "G2")};
  rod.where = card.place;
  in.bulk.add_element(ElementKind::structural, rod.id, card.place);
  in.bulk.rods.push_back(rod);
}

void read_rod(const Card& card, const Reading& in) {
  add_rod(card, in, "CROD", card.id_or(2, card.id(1, "EID"), "PID"), 3);
}
void read_tube(const Card& card, const Reading& in) {
  add_rod(card, in, "CTUBE", card.id_or(2, card.id(1, "EID"), "PID"), 3);
}

void read_conrod(const Card& card, const Reading& in) {
  const Id id = card.id(1, "EID");
  RodSection section{card.id(4, "MID"), card.real_or(5, 0.0, "A"), card.real_or(6, 0.0, "J"),
                     card.real_or(8, 0.0, "NSM")};
  add_rod(card, in, "CONROD", 0, 2);
  in.bulk.conrods.try_emplace(id, PropertyCard{"CONROD", section, card.place});
}

constexpr auto beam_readers = std::to_array<CardReader>({{"CBAR", read_beam},
                                                         {"CBEAM", read_beam},
                                                         {"BAROR", read_baror},
                                                         {"BEAMOR", read_beamor},
                                                         {"CROD", read_rod},
                                                         {"CTUBE", read_tube},
                                                         {"CONROD", read_conrod}});

}  // namespace

std::span<const CardReader> beam_cards() { return beam_readers; }

}  // namespace kalfem::nastran
