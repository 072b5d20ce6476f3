// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Reads the lines of *MPC: a type and its nodes, on further lines where they begin with a number or nothing.
class MultiPointReader {
public:
  MultiPointReader(PlacedDeck& deck, Kinematics& motions) : deck_(deck), motions_(motions) {}

  void read(const PlacedBlock& at);

private:
  struct Entry {
    std::string type;
    Where where;
    std::vector<std::vector<Index>> nodes;  ///< a list for each field
  };

  void apply(const Entry& entry);
  void apply_pairs(const Entry& entry);
  void equal(Index dependent, Index leader, int first, int last);
  void keep_distance(Index dependent, Index leader);
  void keep_on_line(const std::vector<Index>& nodes, const Where& where);
  void keep_in_plane(const std::vector<Index>& nodes, const Where& where);
  void interpolate(Index node, const std::vector<Index>& leaders);
  [[nodiscard]] Eigen::Vector3d at(Index node) const { return deck_.mesh.nodes.col(node); }
  [[nodiscard]] std::string name() const { return name_; }

  PlacedDeck& deck_;
  Kinematics& motions_;
  std::string name_;
};

// First the lines are joined to entries, since the nodes of one entry may go on in further lines; then each entry is
// applied by its type.
void MultiPointReader::read(const PlacedBlock& block) {
  std::vector<Entry> entries;
  for (const auto& line : block.block->lines) {
    std::size_t first = 0;
    const std::string& start = line.field(0);
    const bool goes_on = start.empty() || to_integer(start).has_value();
    if (!goes_on) {
      entries.push_back({upper_case(start), line.where, {}});
      first = 1;
    } else if (entries.empty()) {
      deck_.problems.add(line.where, "the line cannot be read", "*MPC expects a type and its nodes",
                         "begin with the type");
      continue;
    } else if (start.empty() || start == "0") {
      first = 1;
    }
    for (std::size_t i = first; i < line.fields.size(); ++i)
      if (const auto& nodes = line.field(i); !nodes.empty())
        entries.back().nodes.push_back(deck_.node_list({nodes, line.where}, block.place));
  }
  for (const auto& entry : entries) apply(entry);
}

void MultiPointReader::apply(const Entry& entry) {
  name_ = "mpc." + std::to_string(entry.where.line);
  const std::string& type = entry.type;
  std::vector<Index> all;
  for (const auto& list : entry.nodes) all.insert(all.end(), list.begin(), list.end());
  if (std::ranges::any_of(entry.nodes, [](const auto& list) { return list.empty(); })) return;
  if (type == "BEAM" || type == "TIE" || type == "PIN" || type == "LINK") return apply_pairs(entry);
  if (type == "STRAIGHT") return keep_on_line(all, entry.where);
  if (type == "PLANE") return keep_in_plane(all, entry.where);
  if (type == "SLIDER") {
    if (entry.nodes.size() >= 3) {
      // The first node stays on the line of the other two.
      for (const Index node : entry.nodes[0])
        keep_on_line({entry.nodes[1].front(), entry.nodes[2].front(), node}, entry.where);
      return;
    }
  } else if (type == "LINEAR" || type == "QUADRATIC") {
    const std::size_t leaders = type == "LINEAR" ? 2 : 3;
    if (all.size() == leaders + 1) return interpolate(all.front(), {all.begin() + 1, all.end()});
  } else if (type == "DIST") {
    deck_.notes.add(deck_.problems.location(entry.where), "*MPC of type DIST", "limits of a distance are ignored",
                    DeckNoteKind::doubtful);
    return;
  } else {
    deck_.problems.add(entry.where, "*MPC of type " + to_string(type) + " is not read",
                       "supported: BEAM, TIE, PIN, LINK, SLIDER, LINEAR, QUADRATIC, STRAIGHT and PLANE",
                       "write it as *EQUATION");
    return;
  }
  deck_.problems.add(entry.where, "*MPC of type " + to_string(type) + " has " + std::to_string(all.size()) + " nodes",
                     "", "correct the line");
}

/// Every node of the first field follows the node of the second one, or that at the same place of its set.
void MultiPointReader::apply_pairs(const Entry& entry) {
  if (entry.nodes.size() < 2 || (entry.nodes[1].size() != 1 && entry.nodes[1].size() != entry.nodes[0].size())) {
    deck_.problems.add(entry.where,
                       "*MPC of type " + entry.type + " needs two nodes, or a set and a node, or two sets of one size",
                       "", "correct the line");
    return;
  }
  for (std::size_t i = 0; i < entry.nodes[0].size(); ++i) {
    const Index dependent = entry.nodes[0][i], leader = entry.nodes[1][entry.nodes[1].size() == 1 ? 0 : i];
    if (dependent == leader) continue;
    if (entry.type == "BEAM") motions_.add_link(name(), leader, {dependent}, {true, true, true, true, true, true});
    if (entry.type == "TIE") equal(dependent, leader, 0, 6);
    if (entry.type == "PIN") equal(dependent, leader, 0, 3);
    if (entry.type == "LINK") keep_distance(dependent, leader);
  }
}

// TIE makes all six motions equal, PIN the displacements.
void MultiPointReader::equal(Index dependent, Index leader, int first, int last) {
  for (int d = first; d < last; ++d)
    motions_.add_equation(name(), {{{dependent, d}, 1.0}, {{leader, d}, -1.0}}, NodalDof{dependent, d});
}

/// n . (u_a - u_b) = 0 along the line between them.
void MultiPointReader::keep_distance(Index dependent, Index leader) {
  const Eigen::Vector3d along = at(dependent) - at(leader);
  if (along.norm() == 0.0) return equal(dependent, leader, 0, 3);
  DofSum terms;
  for (int a = 0; a < 3; ++a) {
    const double share = along[a] / along.norm();
    if (share == 0.0) continue;
    terms.push_back({{dependent, a}, share});
    terms.push_back({{leader, a}, -share});
  }
  motions_.add_equation(name(), std::move(terms));
}

/// Nodes from the third on stay on the line of the first two, which may stretch.
void MultiPointReader::keep_on_line(const std::vector<Index>& nodes, const Where& where) {
  if (nodes.size() < 3) return;
  const Eigen::Vector3d along = at(nodes[1]) - at(nodes[0]);
  if (along.norm() == 0.0) {
    deck_.problems.add(where, "the first two nodes, which define the line, coincide", "they must define it",
                       "correct the line");
    return;
  }
  const Eigen::Vector3d tangent = along.normalized(), first = tangent.unitOrthogonal(), second = tangent.cross(first);
  for (std::size_t i = 2; i < nodes.size(); ++i) {
    const double s = tangent.dot(at(nodes[i]) - at(nodes[0])) / along.norm();
    for (const Eigen::Vector3d& normal : {first, second}) {
      DofSum terms;
      for (int a = 0; a < 3; ++a) {
        terms.push_back({{nodes[i], a}, normal[a]});
        terms.push_back({{nodes[0], a}, -(1.0 - s) * normal[a]});
        terms.push_back({{nodes[1], a}, -s * normal[a]});
      }
      motions_.add_equation(name(), std::move(terms));
    }
  }
}

/// Nodes from the fourth on stay in the plane of the first three: n . u = sum of n . u_k by their shares of area.
void MultiPointReader::keep_in_plane(const std::vector<Index>& nodes, const Where& where) {
  if (nodes.size() < 4) return;
  const Eigen::Vector3d p = at(nodes[1]) - at(nodes[0]), q = at(nodes[2]) - at(nodes[0]);
  const Eigen::Vector3d cross = p.cross(q);
  if (cross.norm() < 1e-9 * p.norm() * q.norm() || p.norm() == 0.0 || q.norm() == 0.0) {
    deck_.problems.add(where, "the first three nodes, which define the plane, lie on one line", "they must define it",
                       "correct the line");
    return;
  }
  const Eigen::Vector3d normal = cross.normalized();
  for (std::size_t i = 3; i < nodes.size(); ++i) {
    const Eigen::Vector3d r = at(nodes[i]) - at(nodes[0]);
    const double s = normal.dot(r.cross(q)) / cross.norm(), t = normal.dot(p.cross(r)) / cross.norm();
    DofSum terms;
    for (int a = 0; a < 3; ++a) {
      terms.push_back({{nodes[i], a}, normal[a]});
      terms.push_back({{nodes[0], a}, -(1.0 - s - t) * normal[a]});
      terms.push_back({{nodes[1], a}, -s * normal[a]});
      terms.push_back({{nodes[2], a}, -t * normal[a]});
    }
    motions_.add_equation(name(), std::move(terms));
  }
}

// With s the place of the node between the end nodes, the shares are 1 - s and s, or with a middle node (1 - s)(1 - 2
// s), 4 s (1 - s) and s (2 s - 1).
/// All motions of a node by Lagrange's polynomial through those of two or three others, the third amid the others.
void MultiPointReader::interpolate(Index node, const std::vector<Index>& leaders) {
  const Index last = leaders.size() == 2 ? leaders[1] : leaders[2];
  const Eigen::Vector3d along = at(last) - at(leaders[0]);
  const double length = along.squaredNorm();
  const double s = length > 0.0 ? along.dot(at(node) - at(leaders[0])) / length : 0.5;
  const std::vector<double> shares =
      leaders.size() == 2 ? std::vector<double>{1.0 - s, s}
                          : std::vector<double>{(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)};
  for (int d = 0; d < 6; ++d) {
    DofSum terms = {{{node, d}, 1.0}};
    for (std::size_t i = 0; i < leaders.size(); ++i)
      if (shares[i] != 0.0) terms.push_back({{leaders[i], d}, -shares[i]});
    motions_.add_equation(name(), std::move(terms), NodalDof{node, d});
  }
}

}  // namespace

void read_multi_point_constraints(PlacedDeck& deck, Kinematics& motions) {
  MultiPointReader reader(deck, motions);
  for (const auto& at : deck.blocks("MPC")) reader.read(at);
}

}  // namespace kalfem::abaqus
