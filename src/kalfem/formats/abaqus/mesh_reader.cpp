// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <numbers>

#include "kalfem/formats/abaqus/deck_reader.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// The set of that name, made where it is new.
RawSet& set_named(std::map<std::string, RawSet>& sets, const std::string& name) {
  RawSet& set = sets[upper_case(name)];
  if (set.name.empty()) set.name = name;
  return set;
}

/// The piece of a set that collects numbers of its own scope.
RawSet::Piece& own_piece(RawSet& set) {
  if (set.pieces.empty() || !set.pieces.back().instance.empty() || set.pieces.back().of_elements)
    set.pieces.emplace_back();
  return set.pieces.back();
}

/// Cartesian coordinates of a node given in cylindrical (r, theta in degrees, z) or spherical ones (r, theta in degrees
/// about z, phi in degrees from the x-y plane).
Eigen::Vector3d cartesian(const Eigen::Vector3d& given, const std::string& axes) {
  const double theta = given.y() * std::numbers::pi / 180.0;
  if (axes == "C") return {given.x() * std::cos(theta), given.x() * std::sin(theta), given.z()};
  const double phi = given.z() * std::numbers::pi / 180.0;
  return {given.x() * std::cos(theta) * std::cos(phi), given.x() * std::sin(theta) * std::cos(phi),
          given.x() * std::sin(phi)};
}

}  // namespace

/// First line: origin and a point on the x axis; second: a point in the x-y plane (by default the axes stay upright).
void MeshReader::read_system() {
  std::array<double, 9> values{};
  std::size_t count = 0;
  const Where where = lines_.where();
  for (std::string_view line; lines_.next_data(line);) {
    FieldCursor fields(line);
    for (std::string_view field; fields.next(field);) {
      if (count == 9) {
        add_extra("*SYSTEM", "fields behind the third point", "they are ignored");
        continue;
      }
      const auto number = field.empty() ? 0.0 : to_number(field);
      if (!number)
        problems_.fail(lines_.where(), "'" + to_string(field) + "' is not a number", "*SYSTEM expects coordinates");
      values[count++] = *number;
    }
  }
  forget_system();
  if (count == 0) return;
  const Eigen::Vector3d origin(values[0], values[1], values[2]);
  system_.translation() = origin;
  if (count <= 3) return;
  const Eigen::Vector3d x = Eigen::Vector3d(values[3], values[4], values[5]) - origin;
  const Eigen::Vector3d in_plane = count > 6
                                       ? Eigen::Vector3d(Eigen::Vector3d(values[6], values[7], values[8]) - origin)
                                       : Eigen::Vector3d(-x.y(), x.x(), 0.0);
  const auto axes = axes_from(x, in_plane);
  if (!axes)
    problems_.fail(where, "the points of *SYSTEM lie on one line", "they must define two directions", "correct them");
  system_.linear() = *axes;
}

// Reads the lines of *NODE. NSET= puts the nodes into a set as well; it may be one that exists, and then grows.
// Places in cylindrical or spherical coordinates become Cartesian first, then those of *SYSTEM become global.
void MeshReader::read_nodes(Scope& scope, const Keyword& keyword) {
  if (!keyword.get("INPUT").empty()) lines_.insert(keyword.get("INPUT"), keyword.where);
  const std::string axes = keyword.word("SYSTEM");
  if (!axes.empty() && axes != "R" && axes != "C" && axes != "S")
    problems_.fail(keyword.where, "*NODE has SYSTEM=" + to_string(axes), "it must be R, C or S", "correct it");
  const std::string set_name = keyword.get("NSET");
  RawSet::Piece* piece = set_name.empty() ? nullptr : &own_piece(set_named(scope.node_sets, set_name));
  for (std::string_view line; lines_.next_data(line);)
    if (read_node(scope.nodes, line, axes) && piece) piece->labels.push_back(scope.nodes.labels.back());
}

/// Counts a field that no line of the keyword has.
void MeshReader::add_extra(const char* card, const char* name, const char* consequence) {
  for (auto& extra : deck_.extra_fields)
    if (extra.card == card && extra.field == name) {
      ++extra.count;
      return;
    }
  deck_.extra_fields.push_back({card, name, consequence, lines_.where(), 1});
}

bool MeshReader::read_node(RawNodes& nodes, std::string_view line, const std::string& axes) {
  FieldCursor fields(line);
  std::string_view field;
  fields.next(field);
  const auto label = to_label(field);
  if (!label) {
    problems_.add(lines_.where(), "'" + to_string(field) + "' is not a node number",
                  "a line of *NODE must begin with a node number > 0", "correct the line");
    return false;
  }
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  int axis = 0;
  while (axis < 3 && fields.next(field)) {
    // Two commas in a row, or one too many: what is empty counts as nothing.
    if (field.empty()) continue;
    const auto number = to_number(field);
    if (!number) {
      problems_.add(lines_.where(), "'" + to_string(field) + "' of node " + std::to_string(*label) + " is not a number",
                    "a node takes up to three finite coordinates", "correct the line");
      return false;
    }
    position[axis++] = *number;
  }
  while (fields.next(field))
    if (!field.empty()) add_extra("*NODE", "fields behind the coordinates", "directions at nodes are not read");
  if (axes == "C" || axes == "S") position = cartesian(position, axes);
  position = system_ * position;
  nodes.labels.push_back(*label);
  nodes.coordinates.insert(nodes.coordinates.end(), position.begin(), position.end());
  nodes.places.push_back(lines_.where());
  return true;
}

// Types are kept by name, so that each is interpreted once and its remark is noted once. A type that is not known is
// a problem, since the model would lack its stiffness.
int MeshReader::type_of(const Keyword& keyword) {
  const std::string name = upper_case(keyword.get("TYPE"));
  for (std::size_t i = 0; i < deck_.types.size(); ++i)
    if (deck_.types[i].name == name) return static_cast<int>(i);
  const auto type = element_type(name);
  if (!type) {
    problems_.add(
        keyword.where,
        name.empty() ? "*ELEMENT has no TYPE" : "elements of type " + to_string(name) + " cannot be read",
        "the model would be incomplete without them",
        "use shells (S3 S4 S6 S8), solids (C3D4 to C3D20), beams (B31 B32 B33), trusses, springs, dashpots or "
        "masses");
    return -1;
  }
  deck_.types.push_back({name, *type});
  return static_cast<int>(deck_.types.size()) - 1;
}

void MeshReader::read_elements(Scope& scope, const Keyword& keyword) {
  if (!keyword.get("INPUT").empty()) lines_.insert(keyword.get("INPUT"), keyword.where);
  const int type = type_of(keyword);
  if (type < 0) return;
  const std::string set_name = keyword.get("ELSET");
  RawSet::Piece* piece = set_name.empty() ? nullptr : &own_piece(set_named(scope.element_sets, set_name));
  for (std::string_view line; lines_.next_data(line);) {
    const std::size_t before = scope.elements.size();
    read_element(scope, line, type);
    if (piece && scope.elements.size() > before) piece->labels.push_back(scope.elements.back().label);
  }
}

/// A number, or "instance.number" as a negative position in the list of named nodes; 0 where it is neither.
std::int64_t MeshReader::node_reference(Scope& scope, std::string_view field) {
  if (const auto label = to_label(field)) return *label;
  if (field.find('.') == std::string_view::npos) return 0;
  scope.named_nodes.push_back({std::string(field), lines_.where()});
  return -static_cast<std::int64_t>(scope.named_nodes.size());
}

/// Number and nodes of one element, over several lines where its line ends in a comma or, having many nodes, is full.
void MeshReader::read_element(Scope& scope, std::string_view line, int type) {
  const auto& [name, kind] = deck_.types[static_cast<std::size_t>(type)];
  RawElement element;
  element.where = lines_.where();
  element.type = type;
  element.first = static_cast<std::int64_t>(scope.connectivity.size());
  FieldCursor fields(line);
  std::string_view field;
  fields.next(field);
  const auto label = to_label(field);
  const auto drop = [&] { scope.connectivity.resize(static_cast<std::size_t>(element.first)); };
  if (!label) {
    problems_.add(element.where, "'" + to_string(field) + "' is not an element number",
                  "a line of *ELEMENT must begin with an element number > 0", "correct the line");
    return;
  }
  element.label = *label;
  const int most = kind.nodes + (kind.family == Family::beam ? 1 : 0);
  int count = 0, on_line = 1;
  for (;;) {
    while (fields.next(field)) {
      ++on_line;
      if (field.empty()) continue;
      const std::int64_t node = node_reference(scope, field);
      if (node == 0) {
        problems_.add(lines_.where(),
                      "'" + to_string(field) + "' of element " + std::to_string(*label) + " is not a node", "",
                      "write the numbers of its nodes");
        return drop();
      }
      scope.connectivity.push_back(node);
      ++count;
    }
    const bool goes_on = count < kind.nodes && (line.ends_with(',') || on_line >= 11);
    if (!goes_on || !lines_.next_data(line)) break;
    fields = FieldCursor(line);
    on_line = 0;
  }
  if (count < kind.nodes || count > most) {
    problems_.add(element.where,
                  "element " + std::to_string(*label) + " of type " + name + " has " + std::to_string(count) + " nodes",
                  "it needs " + std::to_string(kind.nodes), "correct the line or the type");
    return drop();
  }
  if (count > kind.nodes) element.extra_node = kind.nodes;
  scope.elements.push_back(element);
}

// A set is a list of pieces, one for each keyword of its name. Nothing is looked up here: numbers and names may be
// defined further down.
void MeshReader::read_set(Scope& scope, const Keyword& keyword, bool of_nodes) {
  const std::string name = keyword.get(of_nodes ? "NSET" : "ELSET");
  if (name.empty()) {
    problems_.add(keyword.where, keyword.title + " has no name", "a set needs a name",
                  std::string("write ") + keyword.title + ", " + (of_nodes ? "NSET" : "ELSET") + "=<name>");
    return;
  }
  if (!keyword.get("INPUT").empty()) lines_.insert(keyword.get("INPUT"), keyword.where);
  RawSet& set = set_named(of_nodes ? scope.node_sets : scope.element_sets, name);
  set.internal = set.internal || keyword.has("INTERNAL");
  RawSet::Piece piece;
  piece.where = keyword.where;
  piece.instance = keyword.get("INSTANCE");
  if (of_nodes && keyword.has("ELSET")) piece.of_elements = SetReference{keyword.get("ELSET"), keyword.where};
  const bool generated = keyword.has("GENERATE");
  for (std::string_view line; lines_.next_data(line);)
    generated ? read_generated_piece(piece, line) : read_listed_piece(piece, line);
  set.pieces.push_back(std::move(piece));
}

void MeshReader::read_generated_piece(RawSet::Piece& piece, std::string_view line) {
  const auto fields = split_fields(line);
  const auto number = [&](std::size_t i) { return i < fields.size() ? to_label(fields[i]) : std::nullopt; };
  const auto first = number(0);
  const auto last = fields.size() < 2 || fields[1].empty() ? first : number(1);
  const auto step = fields.size() < 3 || fields[2].empty() ? std::optional<std::int64_t>(1) : number(2);
  if (!first || !last || !step || *last < *first)
    problems_.add(lines_.where(), "'" + to_string(line) + "' is not a range",
                  "GENERATE expects the first number, the last number and the step, ascending", "correct the line");
  else
    piece.ranges.push_back({*first, *last, *step});
  if (fields.size() > 3) add_extra("*NSET and *ELSET, GENERATE", "fields behind the step", "they are ignored");
}

void MeshReader::read_listed_piece(RawSet::Piece& piece, std::string_view line) {
  FieldCursor fields(line);
  for (std::string_view field; fields.next(field);) {
    if (field.empty()) continue;
    if (const auto label = to_integer(field))
      piece.labels.push_back(*label);
    else
      piece.names.push_back({std::string(field), lines_.where()});
  }
}

}  // namespace kalfem::abaqus
