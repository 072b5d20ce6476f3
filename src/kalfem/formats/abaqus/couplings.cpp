// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

using Directions = Kinematics::Directions;
constexpr Directions all_directions = {true, true, true, true, true, true};
constexpr Directions displacements = {true, true, true, false, false, false};

/// The one node that a parameter names; nothing and a problem where it is none.
std::optional<Index> single_node(PlacedDeck& deck, const std::string& text, int place, const Where& where,
                                 const std::string& what) {
  if (text.empty()) {
    deck.problems.add(where, "there is no " + what, "", "name a node");
    return {};
  }
  const auto nodes = deck.node_list({text, where}, place);
  if (nodes.size() == 1) return nodes.front();
  if (!nodes.empty())
    deck.problems.add(where, what + " '" + to_string(text) + "' has " + std::to_string(nodes.size()) + " nodes",
                      "it must be a single node", "name one");
  return {};
}

/// Lines of first and last direction; without lines all.
Directions read_tied(PlacedDeck& deck, std::span<const DataLine> lines, std::size_t first_field) {
  Directions tied{};
  bool any = false;
  for (const auto& line : lines) {
    if (line.field(first_field).empty()) continue;
    const auto first = to_integer(line.field(first_field));
    const auto last = line.field(first_field + 1).empty() ? first : to_integer(line.field(first_field + 1));
    if (!first || !last || *first < 1 || *last > 6 || *last < *first) {
      deck.problems.add(line.where, "the directions of the coupling cannot be read",
                        "write the first and the last direction, 1 to 6", "correct the line");
      continue;
    }
    for (auto d = *first; d <= *last; ++d) tied[static_cast<std::size_t>(d - 1)] = true;
    any = true;
  }
  return any ? tied : all_directions;
}

// Per tied local direction e: e . (u_node - u of the rigid motion there) = 0, in global components.
/// Nodes follow a master in some directions of local axes.
void couple_in_axes(PlacedDeck& deck, const std::string& name, Index master, const std::vector<Index>& nodes,
                    const Directions& tied, const LocalAxes& axes, Kinematics& motions) {
  for (const Index node : nodes) {
    if (node == master) continue;
    const Eigen::Vector3d arm = deck.mesh.nodes.col(node) - deck.mesh.nodes.col(master);
    const Eigen::Matrix3d local = axes.at(deck.mesh.nodes.col(node));
    for (int d = 0; d < 6; ++d) {
      if (!tied[static_cast<std::size_t>(d)]) continue;
      const int block = d < 3 ? 0 : 3;
      DofSum terms;
      for (int a = 0; a < 3; ++a) {
        const double share = local(a, d - block);
        if (share == 0.0) continue;
        terms.push_back({{node, block + a}, -share});
        for (const auto& [dof, factor] : slave_motion(master, block + a, arm)) terms.push_back({dof, share * factor});
      }
      motions.add_equation(name, std::move(terms));
    }
  }
}

// With all displacements and all rotations tied or free alike, local axes do not matter and the coupling is a rigid
// link.
void couple(PlacedDeck& deck, const std::string& name, Index master, const std::vector<Index>& nodes,
            const Directions& tied, const std::string& orientation, const PlacedBlock& at, Kinematics& motions) {
  const auto even = [&](std::size_t block) { return tied[block] == tied[block + 1] && tied[block] == tied[block + 2]; };
  if (orientation.empty() || (even(0) && even(3))) return motions.add_link(name, master, nodes, tied);
  couple_in_axes(deck, name, master, nodes, tied,
                 orientation_axes(deck, orientation, at.place, at.block->keyword.where), motions);
}

// The reference node takes the weighted mean motion of the coupled nodes (RBE3). Only their displacements count;
// nodes without weight take no part.
void distribute(const std::string& name, Index reference, const Surface& surface, const Directions& tied,
                const Where& where, Kinematics& motions) {
  WeightedLink link;
  link.name = name;
  link.follower = reference;
  link.tied = tied;
  for (std::size_t i = 0; i < surface.nodes.size(); ++i)
    if (surface.weights[i] > 0.0) link.shares.push_back({surface.nodes[i], surface.weights[i], displacements});
  motions.add_weighted_link(std::move(link), where);
}

/// CalculiX's *DISTRIBUTING COUPLING: u = sum w_i u_i / sum w_i, which shares forces and no moments.
void distribute_forces(const std::string& name, Index reference, const Surface& surface, Kinematics& motions) {
  double total = 0.0;
  for (const double weight : surface.weights) total += weight;
  if (!(total > 0.0)) return;
  for (int d = 0; d < 3; ++d) {
    DofSum terms = {{{reference, d}, -1.0}};
    for (std::size_t i = 0; i < surface.nodes.size(); ++i)
      if (surface.weights[i] != 0.0 && surface.nodes[i] != reference)
        terms.push_back({{surface.nodes[i], d}, surface.weights[i] / total});
    motions.add_equation(name, std::move(terms), NodalDof{reference, d});
  }
}

// *DISTRIBUTING: displacements are always shared, rotations that its lines name, or all without lines. In CalculiX the
// loads of the reference node are along the axes of the ORIENTATION.
void read_distributing(PlacedDeck& deck, const PlacedBlock& at, const Block& option, const std::string& name,
                       Index reference, const Surface& surface, Kinematics& motions) {
  const Keyword& keyword = at.block->keyword;
  const std::string weighting = option.keyword.word("WEIGHTINGMETHOD");
  if (!weighting.empty() && weighting != "UNIFORM")
    deck.problems.add(option.keyword.where, "*DISTRIBUTING has WEIGHTING METHOD=" + to_string(weighting),
                      "weights that fall off with the distance are not read", "use UNIFORM");
  if (const auto kind = option.keyword.word("COUPLING"); !kind.empty() && kind != "CONTINUUM")
    deck.problems.add(option.keyword.where, "*DISTRIBUTING has COUPLING=" + to_string(kind),
                      "rotations of the coupled nodes take no part here", "use CONTINUUM");
  Directions tied = read_tied(deck, option.lines, 0);
  for (std::size_t d = 0; d < 3; ++d) tied[d] = true;
  const std::string orientation = keyword.get("ORIENTATION");
  if (!orientation.empty() && !deck.of_abaqus()) {
    deck.load_axes[reference] =
        orientation_axes(deck, orientation, at.place, keyword.where).at(deck.mesh.nodes.col(reference));
    deck.notes.add(deck.problems.location(keyword.where), "*COUPLING, ORIENTATION with *DISTRIBUTING",
                   "as in CalculiX, loads of the reference node are along these axes; Abaqus takes global ones",
                   DeckNoteKind::doubtful);
  }
  distribute(name, reference, surface, tied, keyword.where, motions);
}

// *COUPLING names a surface and a reference node; the option behind it decides how they move. Kinematic: the nodes
// follow the reference node. Distributing: the reference node follows the nodes. INFLUENCE RADIUS keeps those near
// it.
void read_coupling(PlacedDeck& deck, const PlacedBlock& at, Kinematics& motions) {
  const Keyword& keyword = at.block->keyword;
  const auto reference = single_node(deck, keyword.get("REFNODE"), at.place, keyword.where, "reference node");
  const Surface surface = find_surface(deck, keyword.get("SURFACE"), at.place, keyword.where);
  if (!reference || surface.nodes.empty()) return;
  std::string name = keyword.get("CONSTRAINTNAME");
  if (name.empty()) name = "coupling." + std::to_string(keyword.where.line);
  name = deck.place(at.place).full_name(name);
  Surface used = surface;
  if (const auto radius = number_parameter(keyword, "INFLUENCERADIUS", deck.problems)) {
    used.nodes.clear();
    used.weights.clear();
    for (std::size_t i = 0; i < surface.nodes.size(); ++i)
      if ((deck.mesh.nodes.col(surface.nodes[i]) - deck.mesh.nodes.col(*reference)).norm() <= *radius) {
        used.nodes.push_back(surface.nodes[i]);
        used.weights.push_back(surface.weights[i]);
      }
  }
  if (const Block* kinematic = at.block->option("KINEMATIC"))
    couple(deck, name, *reference, used.nodes, read_tied(deck, kinematic->lines, 0), keyword.get("ORIENTATION"), at,
           motions);
  else if (const Block* distributing = at.block->option("DISTRIBUTING"))
    read_distributing(deck, at, *distributing, name, *reference, used, motions);
  else
    deck.problems.add(keyword.where, "*COUPLING '" + to_string(name) + "' has neither *KINEMATIC nor *DISTRIBUTING",
                      "one of these keywords must follow it", "add it");
}

}  // namespace

// The older keywords name nodes in other ways: *KINEMATIC COUPLING in its lines, with their directions; *DISTRIBUTING
// COUPLING by an element DCOUP3D, whose node is the reference, and weights in its lines.
void read_couplings(PlacedDeck& deck, Kinematics& motions) {
  for (const auto& at : deck.blocks("COUPLING")) read_coupling(deck, at, motions);
  for (const auto& at : deck.blocks("KINEMATICCOUPLING")) {
    const Keyword& keyword = at.block->keyword;
    const auto reference = single_node(deck, keyword.get("REFNODE"), at.place, keyword.where, "reference node");
    if (!reference) continue;
    const std::string name = deck.place(at.place).full_name("coupling." + std::to_string(keyword.where.line));
    for (const auto& line : at.block->lines)
      couple(deck, name, *reference, deck.node_list({line.field(0), line.where}, at.place),
             read_tied(deck, {&line, 1}, 1), keyword.get("ORIENTATION"), at, motions);
  }
  std::vector<Index> nodes;
  for (const auto& at : deck.blocks("DISTRIBUTINGCOUPLING")) {
    const Keyword& keyword = at.block->keyword;
    const auto elements = deck.element_list({keyword.get("ELSET"), keyword.where}, at.place);
    if (elements.size() != 1) {
      deck.problems.add(
          keyword.where, "*DISTRIBUTING COUPLING has " + std::to_string(elements.size()) + " reference elements",
          "it needs one element of type DCOUP3D, which holds its reference node", "name that element by ELSET");
      continue;
    }
    if (!deck.nodes_of(deck.elements[static_cast<std::size_t>(elements.front())], nodes)) continue;
    Surface surface;
    for (const auto& line : at.block->lines)
      for (const Index node : deck.node_list({line.field(0), line.where}, at.place)) {
        surface.nodes.push_back(node);
        surface.weights.push_back(number_or(line, 1, 1.0, "a weight", deck.problems));
      }
    const std::string name = deck.spelled_set(keyword.get("ELSET"), at.place, false);
    deck.notes.add(deck.problems.location(keyword.where), "*DISTRIBUTING COUPLING",
                   deck.of_abaqus() ? "read as in Abaqus, with moments, because the deck has Abaqus keywords"
                                    : "read as in CalculiX: the reference node shares its forces without moments",
                   DeckNoteKind::doubtful);
    if (deck.of_abaqus())
      distribute(name, nodes.front(), surface, all_directions, keyword.where, motions);
    else
      distribute_forces(name, nodes.front(), surface, motions);
  }
}

/// Nodes of sets or of elements follow the reference node; CalculiX has the rotations as displacements of a ROT NODE.
void read_rigid_bodies(PlacedDeck& deck, Kinematics& motions) {
  std::vector<Index> of_element;
  for (const auto& at : deck.blocks("RIGIDBODY")) {
    const Keyword& keyword = at.block->keyword;
    std::vector<Index> tied, pinned;
    const auto append = [&](const char* parameter, std::vector<Index>& nodes) {
      if (keyword.get(parameter).empty()) return;
      const auto list = deck.node_list({keyword.get(parameter), keyword.where}, at.place);
      nodes.insert(nodes.end(), list.begin(), list.end());
    };
    append("NSET", tied);
    append("TIENSET", tied);
    append("PINNSET", pinned);
    if (!keyword.get("ELSET").empty())
      for (const Index element : deck.element_list({keyword.get("ELSET"), keyword.where}, at.place))
        if (deck.nodes_of(deck.elements[static_cast<std::size_t>(element)], of_element))
          tied.insert(tied.end(), of_element.begin(), of_element.end());
    if (keyword.has("ANALYTICALSURFACE"))
      deck.notes.add(deck.problems.location(keyword.where), "analytical surfaces of rigid bodies",
                     "they have no mass and no stiffness", DeckNoteKind::unused);
    std::ranges::sort(tied);
    tied.erase(std::unique(tied.begin(), tied.end()), tied.end());
    std::erase_if(pinned, [&](Index node) { return std::ranges::binary_search(tied, node); });
    if (tied.empty() && pinned.empty()) {
      if (keyword.has("ANALYTICALSURFACE")) continue;
      deck.problems.add(keyword.where, "*RIGID BODY has no nodes", "NSET, ELSET, PIN NSET or TIE NSET must name them",
                        "name a set");
      continue;
    }
    std::optional<Index> reference;
    if (keyword.get("REFNODE").empty())
      reference = tied.empty() ? pinned.front() : tied.front();  // any node shows a rigid motion
    else
      reference = single_node(deck, keyword.get("REFNODE"), at.place, keyword.where, "reference node");
    if (!reference) continue;
    if (keyword.word("POSITION") == "CENTEROFMASS")
      deck.notes.add(deck.problems.location(keyword.where), "*RIGID BODY, POSITION=CENTER OF MASS",
                     "the reference node is not moved to the centre of mass", DeckNoteKind::changed);
    const std::string name = deck.place(at.place).full_name("rigid." + std::to_string(keyword.where.line));
    motions.add_link(name, *reference, tied, all_directions);
    if (!pinned.empty()) motions.add_link(name + ".pinned", *reference, pinned, displacements);
    if (!keyword.get("ROTNODE").empty())
      if (const auto rotation = single_node(deck, keyword.get("ROTNODE"), at.place, keyword.where, "rotation node");
          rotation && *rotation != *reference)
        for (int a = 0; a < 3; ++a)
          motions.add_equation(name + ".rotation", {{{*reference, 3 + a}, 1.0}, {{*rotation, a}, -1.0}},
                               NodalDof{*reference, 3 + a});
  }
}

}  // namespace kalfem::abaqus
