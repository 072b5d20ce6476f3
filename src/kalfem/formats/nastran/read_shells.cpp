#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// Where the fields of one kind of shell stand on its card.
struct ShellFields {
  bool triangle;
  std::size_t nodes, node_count, corners;
  std::size_t angle, offset, flag, thickness;
};

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
  if (any) {
    shell.thickness = static_cast<std::int32_t>(in.bulk.corner_thickness.size());
    in.bulk.corner_thickness.push_back(thickness);
  }
  shell.where = card.place;
  in.bulk.element_ids.emplace_back(shell.id, card.place);
  in.bulk.shells.push_back(shell);
}

void read_quad4(const Card& card, const Reading& in) { read_shell(card, in, {false, 3, 4, 4, 7, 8, 10, 11}); }
void read_quad8(const Card& card, const Reading& in) { read_shell(card, in, {false, 3, 8, 4, 15, 16, 17, 11}); }
void read_tria3(const Card& card, const Reading& in) { read_shell(card, in, {true, 3, 3, 3, 6, 7, 10, 11}); }
void read_tria6(const Card& card, const Reading& in) { read_shell(card, in, {true, 3, 6, 3, 9, 10, 14, 11}); }

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
  in.bulk.element_ids.emplace_back(solid.id, card.place);
  in.bulk.solids.push_back(solid);
}

void read_hexa(const Card& card, const Reading& in) { read_solid(card, in, CellShape::hexahedron8, 8, 20); }
void read_penta(const Card& card, const Reading& in) { read_solid(card, in, CellShape::wedge6, 6, 15); }
void read_tetra(const Card& card, const Reading& in) { read_solid(card, in, CellShape::tetrahedron4, 4, 10); }
void read_pyramid(const Card& card, const Reading& in) { read_solid(card, in, CellShape::tetrahedron4, 5, 13, true); }

constexpr auto shell_readers = std::to_array<CardReader>({{"CQUAD4", read_quad4},
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

}  // namespace kalfem::nastran
