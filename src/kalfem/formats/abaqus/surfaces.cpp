// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/kinematics.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

using Corners = std::vector<std::size_t>;

/// Corners of the faces S1, S2, ... of a solid.
const std::vector<Corners>& solid_faces(std::size_t corners) {
  static const std::vector<Corners> tetrahedron = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  static const std::vector<Corners> wedge = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
  static const std::vector<Corners> hexahedron = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                                  {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
  return corners == 4 ? tetrahedron : corners == 6 ? wedge : hexahedron;
}

/// Corners at the ends of every side, in the order of the nodes amid the sides.
std::vector<std::pair<std::size_t, std::size_t>> sides_of(CellShape shape) {
  switch (shape) {
    case CellShape::triangle6:
      return {{0, 1}, {1, 2}, {2, 0}};
    case CellShape::quadrilateral8:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    case CellShape::tetrahedron10:
      return {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    case CellShape::wedge15:
      return {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
    case CellShape::hexahedron20:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    default:
      return {};
  }
}

/// Collects the faces and nodes of one surface.
class SurfaceBuilder {
public:
  explicit SurfaceBuilder(PlacedDeck& deck) : deck_(deck) {}

  void add(const PlacedBlock& at, int depth);
  bool add_named_face(Index element, const std::vector<Index>& nodes, const std::string& label);
  Surface finish();

private:
  void add_nodes(const PlacedBlock& at);
  void add_elements(const PlacedBlock& at);
  void add_face(Index element, const std::vector<Index>& nodes, CellShape shape, const Corners& corners);
  void add_free_faces(const std::vector<Index>& elements);
  void weigh(Index node, double weight);

  PlacedDeck& deck_;
  Surface surface_;
  std::unordered_map<Index, std::size_t> position_;
};

// A node that belongs to several faces collects its share of each.
void SurfaceBuilder::weigh(Index node, double weight) {
  const auto [place, is_new] = position_.try_emplace(node, surface_.nodes.size());
  if (is_new) {
    surface_.nodes.push_back(node);
    surface_.weights.push_back(0.0);
  }
  surface_.weights[place->second] += weight;
}

// A surface is a union of others, a list of nodes (TYPE=NODE, with weights) or a list of element faces. Unions may
// nest; a limit of the depth stops those that contain themselves.
void SurfaceBuilder::add(const PlacedBlock& at, int depth) {
  const Keyword& keyword = at.block->keyword;
  const std::string combine = keyword.word("COMBINE"), type = keyword.word("TYPE");
  if (combine == "UNION" && depth < 20) {
    for (const auto& line : at.block->lines)
      for (std::size_t i = 0; i < line.fields.size(); ++i)
        if (const auto inner = deck_.find_block("SURFACE", line.field(i), at.place); inner.block)
          add(inner, depth + 1);
        else
          deck_.problems.add(line.where, "there is no surface '" + to_string(line.field(i)) + "'");
  } else if (!combine.empty()) {
    deck_.problems.add(keyword.where, "*SURFACE, COMBINE=" + to_string(combine) + " is not read", "unions are",
                       "list faces or nodes");
  } else if (type == "NODE") {
    add_nodes(at);
  } else if (type.empty() || type == "ELEMENT") {
    add_elements(at);
  } else {
    deck_.problems.add(keyword.where, "*SURFACE, TYPE=" + to_string(type) + " is not read",
                       "a surface must consist of nodes or elements", "list faces or nodes");
  }
}

// In a list of nodes the second field is the area of a node; it weighs 1 without one.
void SurfaceBuilder::add_nodes(const PlacedBlock& at) {
  for (const auto& line : at.block->lines)
    for (const Index node : deck_.node_list({line.field(0), line.where}, at.place))
      weigh(node, number_or(line, 1, 1.0, "a weight", deck_.problems));
}

void SurfaceBuilder::add_elements(const PlacedBlock& at) {
  std::vector<Index> nodes;
  for (const auto& line : at.block->lines) {
    const auto elements = deck_.element_list({line.field(0), line.where}, at.place);
    const std::string label = upper_case(line.field(1));
    if (label.empty()) {
      add_free_faces(elements);
      continue;
    }
    for (const Index element : elements) {
      const auto& placed = deck_.elements[static_cast<std::size_t>(element)];
      if (!deck_.nodes_of(placed, nodes)) continue;
      if (!add_named_face(element, nodes, label)) {
        deck_.problems.add(
            line.where,
            "elements of type " + deck_.type_name(placed) + " do not have the face '" + to_string(label) + "'", "",
            "correct the label");
        break;
      }
    }
  }
}

// The face gets the middle nodes of its own sides. Its size is shared equally by its nodes: the weights of a
// distributing coupling are the areas around them.
void SurfaceBuilder::add_face(Index element, const std::vector<Index>& nodes, CellShape shape, const Corners& corners) {
  Face face{{}, corners.size(), element};
  for (const auto corner : corners) face.nodes.push_back(nodes[corner]);
  const auto sides = sides_of(shape);
  const auto first_middle = static_cast<std::size_t>(corner_count(shape));
  const std::size_t count = corners.size() == 2 ? 1 : corners.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t side = 0; side < sides.size(); ++side)
      if (const std::pair forth{corners[i], corners[(i + 1) % corners.size()]}, back{forth.second, forth.first};
          sides[side] == forth || sides[side] == back)
        face.nodes.push_back(nodes[first_middle + side]);
  double size = 0.0;
  const auto at = [&](std::size_t i) -> Eigen::Vector3d { return deck_.mesh.nodes.col(face.nodes[i]); };
  if (corners.size() == 2) size = (at(1) - at(0)).norm();
  if (corners.size() == 3) size = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
  if (corners.size() == 4) size = 0.5 * (at(2) - at(0)).cross(at(3) - at(1)).norm();
  for (const Index node : face.nodes) weigh(node, size / static_cast<double>(face.nodes.size()));
  surface_.faces.push_back(std::move(face));
}

/// S1 to S6 of solids; SPOS, SNEG, S1, S2 and edges E1 to E4 (S3 to S6 in CalculiX) of shells; ends of lines.
bool SurfaceBuilder::add_named_face(Index element, const std::vector<Index>& nodes, const std::string& label) {
  const auto& type = deck_.type_of(deck_.elements[static_cast<std::size_t>(element)]);
  const auto corners = static_cast<std::size_t>(corner_count(type.shape));
  const auto number = label.size() == 2 ? to_integer(label.substr(1)) : std::nullopt;
  if (type.family == Family::solid) {
    const auto& faces = solid_faces(corners);
    if (label[0] != 'S' || !number || *number < 1 || *number > static_cast<std::int64_t>(faces.size())) return false;
    add_face(element, nodes, type.shape, faces[static_cast<std::size_t>(*number - 1)]);
    surface_.faces.back().label = label;
    return true;
  }
  if (corners >= 3) {
    std::optional<std::int64_t> edge;
    if (label[0] == 'E' && number) edge = *number;
    if (label[0] == 'S' && number && *number > 2) edge = *number - 2;
    if (!edge && label != "SPOS" && label != "SNEG" && label != "S1" && label != "S2") return false;
    if (!edge) {
      Corners all(corners);
      for (std::size_t i = 0; i < corners; ++i) all[i] = i;
      add_face(element, nodes, type.shape, all);
      surface_.faces.back().from_below = label == "SNEG" || label == "S1";
      surface_.faces.back().label = label;
      return true;
    }
    if (*edge < 1 || *edge > static_cast<std::int64_t>(corners)) return false;
    const auto first = static_cast<std::size_t>(*edge - 1);
    add_face(element, nodes, type.shape, {first, (first + 1) % corners});
    return true;
  }
  if (label == "END1")
    weigh(nodes.front(), 1.0);
  else if (label == "END2")
    weigh(nodes[static_cast<std::size_t>(type.nodes - 1)], 1.0);
  else
    for (int i = 0; i < type.nodes; ++i) weigh(nodes[static_cast<std::size_t>(i)], 1.0);
  return true;
}

// First pass: count how often each set of corners is met; second pass: add the faces met once.
/// Shells as a whole; of solids the faces that no other element of the list shares.
void SurfaceBuilder::add_free_faces(const std::vector<Index>& elements) {
  std::map<std::vector<Index>, int> uses;
  std::vector<Index> nodes;
  const auto key_of = [&](const Corners& corners) {
    std::vector<Index> key;
    for (const auto corner : corners) key.push_back(nodes[corner]);
    std::ranges::sort(key);
    return key;
  };
  for (int pass = 0; pass < 2; ++pass)
    for (const Index element : elements) {
      const auto& placed = deck_.elements[static_cast<std::size_t>(element)];
      const auto& type = deck_.type_of(placed);
      if (!deck_.nodes_of(placed, nodes)) continue;
      if (type.family != Family::solid) {
        if (pass == 1) add_named_face(element, nodes, "SPOS");
        continue;
      }
      const auto& faces = solid_faces(static_cast<std::size_t>(corner_count(type.shape)));
      for (std::size_t i = 0; i < faces.size(); ++i)
        if (pass == 0)
          ++uses[key_of(faces[i])];
        else if (uses.at(key_of(faces[i])) == 1)
          add_named_face(element, nodes, "S" + std::to_string(i + 1));
    }
}

Surface SurfaceBuilder::finish() { return std::move(surface_); }

}  // namespace

std::optional<Face> find_face(PlacedDeck& deck, Index element, const std::string& label) {
  std::vector<Index> nodes;
  SurfaceBuilder builder(deck);
  if (!deck.nodes_of(deck.elements[static_cast<std::size_t>(element)], nodes) ||
      !builder.add_named_face(element, nodes, label))
    return {};
  const auto surface = builder.finish();
  return surface.faces.empty() ? std::nullopt : std::optional(surface.faces.front());
}

Surface find_surface(PlacedDeck& deck, const std::string& name, int place, const Where& where) {
  const auto at = deck.find_block("SURFACE", name, place);
  if (!at.block) {
    // CalculiX lets a set of nodes stand for a surface in some places.
    if (deck.is_node_set(name, place)) {
      Surface surface;
      surface.nodes = deck.node_list({name, where}, place);
      surface.weights.assign(surface.nodes.size(), 1.0);
      return surface;
    }
    deck.problems.add(where, "there is no surface '" + to_string(name) + "'", "", "define it by *SURFACE, NAME=...");
    return {};
  }
  SurfaceBuilder builder(deck);
  builder.add(at, 0);
  return builder.finish();
}

}  // namespace kalfem::abaqus
