#include "kalfem/formats/abaqus/raw_deck.hpp"

#include <cctype>
#include <map>

#include "kalfem/formats/abaqus/fields.hpp"

namespace kalfem::abaqus {

namespace {

/// Letters behind the number of nodes that change nothing in a linear vibration, or nothing that is kept.
std::string remark_of(std::string_view suffix) {
  std::string remark;
  const auto mention = [&](const char* text) { remark += (remark.empty() ? "" : ", ") + std::string(text); };
  for (const char letter : suffix) {
    if (letter == 'H') mention("hybrid formulation (H): the pressure is not a separate unknown here");
    if (letter == 'M') mention("the modified formulation (M) is ignored");
    if (letter == 'T') mention("its temperatures (T) are ignored");
  }
  return remark;
}

bool consists_of(std::string_view text, std::string_view letters) {
  return text.find_first_not_of(letters) == std::string_view::npos;
}

/// C3D followed by the number of nodes and letters.
std::optional<ElementType> solid_type(std::string_view name) {
  std::size_t digits = 0;
  int nodes = 0;
  while (digits < name.size() && digits < 3 && std::isdigit(static_cast<unsigned char>(name[digits])))
    nodes = 10 * nodes + (name[digits++] - '0');
  const auto suffix = name.substr(digits);
  static const std::map<int, CellShape> shapes = {{4, CellShape::tetrahedron4}, {6, CellShape::wedge6},
                                                  {8, CellShape::hexahedron8},  {10, CellShape::tetrahedron10},
                                                  {15, CellShape::wedge15},     {20, CellShape::hexahedron20}};
  const auto shape = shapes.find(nodes);
  if (shape == shapes.end() || !consists_of(suffix, "RHIMTS")) return {};
  ElementType type{Family::solid, shape->second, nodes};
  type.remark = remark_of(suffix);
  const bool reduced = suffix.find('R') != std::string_view::npos;
  const bool incompatible = suffix.find('I') != std::string_view::npos;
  const bool hybrid = suffix.find('H') != std::string_view::npos;
  if (nodes == 8)
    type.kind = reduced                  ? SolidKind::reduced
                : incompatible || hybrid ? SolidKind::standard
                                         : SolidKind::mean_dilatation;
  else if (nodes == 6)
    type.kind = SolidKind::reduced;  // two points
  else if (nodes == 15 || nodes == 20)
    type.kind = reduced ? SolidKind::reduced : SolidKind::full;
  return type;
}

/// S followed by the number of nodes and letters.
std::optional<ElementType> shell_type(std::string_view name) {
  if (name.empty()) return {};
  const auto suffix = name.substr(1);
  static const std::map<char, std::pair<CellShape, int>> shapes = {{'3', {CellShape::triangle3, 3}},
                                                                   {'4', {CellShape::quadrilateral4, 4}},
                                                                   {'6', {CellShape::triangle6, 6}},
                                                                   {'8', {CellShape::quadrilateral8, 8}}};
  const auto shape = shapes.find(name.front());
  if (shape == shapes.end() || !consists_of(suffix, "RSWT5")) return {};
  ElementType type{Family::shell, shape->second.first, shape->second.second};
  type.remark = remark_of(suffix);
  return type;
}

std::optional<ElementType> membrane_type(std::string_view name) {
  auto type = shell_type(name);
  if (type) {
    type->family = Family::membrane;
    type->remark = "it is read as a shell of negligible bending stiffness";
  }
  return type;
}

/// B or PIPE followed by 31, 32 or 33 and letters.
std::optional<ElementType> beam_type(std::string_view name) {
  if (name.size() < 2 || name.front() != '3' || !consists_of(name.substr(2), "RHOST")) return {};
  ElementType type{Family::beam, CellShape::line2, 2};
  if (name[1] == '2') {
    type.shape = CellShape::line3;
    type.nodes = 3;
  } else if (name[1] == '3') {
    type.shear_rigid = true;
  } else if (name[1] != '1') {
    return {};
  }
  type.remark = remark_of(name.substr(2));
  if (name.find("OS") != std::string_view::npos)
    type.remark = "warping is left free: torsion uses the St Venant constant only";
  return type;
}

const std::map<std::string, ElementType, std::less<>>& other_types() {
  static const std::string no_stiffness = "it has no mass, and stiffness at most while in contact";
  static const std::map<std::string, ElementType, std::less<>> types = {
      {"STRI3", {Family::shell, CellShape::triangle3, 3}},
      {"STRI65", {Family::shell, CellShape::triangle6, 6}},
      {"T3D2", {Family::truss, CellShape::line2, 2}},
      {"T3D2H", {Family::truss, CellShape::line2, 2}},
      {"T3D2T", {Family::truss, CellShape::line2, 2}},
      {"T3D3", {Family::truss, CellShape::line3, 3}},
      {"T3D3H", {Family::truss, CellShape::line3, 3}},
      {"SPRING1", {Family::ground_spring, CellShape::point1, 1}},
      {"SPRING2", {Family::spring, CellShape::line2, 2}},
      {"SPRINGA", {Family::axial_spring, CellShape::line2, 2}},
      {"DASHPOT1", {Family::ground_dashpot, CellShape::point1, 1}},
      {"DASHPOT2", {Family::dashpot, CellShape::line2, 2}},
      {"DASHPOTA", {Family::axial_dashpot, CellShape::line2, 2}},
      {"MASS", {Family::mass, CellShape::point1, 1}},
      {"ROTARYI", {Family::rotary_inertia, CellShape::point1, 1}},
      {"DCOUP3D", {Family::reference, CellShape::point1, 1}},
      {"R3D3", {Family::rigid, CellShape::triangle3, 3}},
      {"R3D4", {Family::rigid, CellShape::quadrilateral4, 4}},
      {"RB3D2", {Family::rigid, CellShape::line2, 2}},
      {"SFM3D3", {Family::without_stiffness, CellShape::triangle3, 3, {}, {}, no_stiffness}},
      {"SFM3D4", {Family::without_stiffness, CellShape::quadrilateral4, 4, {}, {}, no_stiffness}},
      {"SFM3D4R", {Family::without_stiffness, CellShape::quadrilateral4, 4, {}, {}, no_stiffness}},
      {"SFM3D6", {Family::without_stiffness, CellShape::triangle6, 6, {}, {}, no_stiffness}},
      {"SFM3D8", {Family::without_stiffness, CellShape::quadrilateral8, 8, {}, {}, no_stiffness}},
      {"SFM3D8R", {Family::without_stiffness, CellShape::quadrilateral8, 8, {}, {}, no_stiffness}},
      {"GAPUNI", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness}},
      {"GAPCYL", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness}},
      {"GAPSPHER", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness}}};
  return types;
}

}  // namespace

std::optional<ElementType> element_type(std::string_view given) {
  const std::string name = upper_case(given);
  if (const auto other = other_types().find(name); other != other_types().end()) return other->second;
  const std::string_view view = name;
  if (view.starts_with("C3D")) return solid_type(view.substr(3));
  if (view.starts_with("M3D")) return membrane_type(view.substr(3));
  if (view.starts_with("PIPE")) return beam_type(view.substr(4));
  if (view.starts_with("B")) return beam_type(view.substr(1));
  if (view.starts_with("S")) return shell_type(view.substr(1));
  return {};
}

}  // namespace kalfem::abaqus
