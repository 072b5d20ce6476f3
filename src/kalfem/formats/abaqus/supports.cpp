// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/kinematics.hpp"

#include <algorithm>

#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/abaqus/steps.hpp"
#include "kalfem/model/placement.hpp"

namespace kalfem::abaqus {

namespace {

using Directions = Kinematics::Directions;

/// All that holds a node in axes of its own.
struct TurnedSupport {
  std::string name;
  Directions held{};
  Directions varying{};  ///< in load cases
};

/// A load case moves, holds or frees single directions: they become degrees of freedom of a local node.
void hold_local_node(PlacedDeck& deck, Index node, const Eigen::Matrix3d& axes, const TurnedSupport& support,
                     Kinematics& motions) {
  const Index local = add_local_node(deck.mesh, node, axes);
  deck.local_nodes[node] = local;
  for (const auto& constraint : local_motions(deck.mesh, node, local))
    motions.add_equation(constraint.name, constraint.terms, constraint.terms.front().first);
  for (int d = 0; d < 6; ++d) {
    if (!support.held[static_cast<std::size_t>(d)]) continue;
    motions.hold(support.name, local, d);
    if (support.varying[static_cast<std::size_t>(d)]) motions.move({local, d});
  }
}

/// Terms of a direction of a node, in its own axes where it has some.
void append_direction(const NodeAxes& axes, Index node, int direction, double factor, DofSum& terms) {
  const auto own = axes.find(node);
  if (own == axes.end()) {
    terms.push_back({{node, direction}, factor});
    return;
  }
  const int block = direction < 3 ? 0 : 3;
  for (int a = 0; a < 3; ++a)
    if (const double share = own->second(a, direction - block); share != 0.0)
      terms.push_back({{node, block + a}, factor * share});
}

/// The degree of freedom that an equation is solved for: its first one, as in Abaqus; in axes of the node's own, the
/// global one that is nearest to it.
NodalDof dependent_dof(const NodeAxes& axes, const NodalDof& first) {
  const auto own = axes.find(first.node);
  if (own == axes.end()) return first;
  Index nearest = 0;
  own->second.col(first.direction % 3).cwiseAbs().maxCoeff(&nearest);
  return {first.node, first.direction / 3 * 3 + static_cast<int>(nearest)};
}

}  // namespace

// *TRANSFORM gives the nodes of a set local axes for *BOUNDARY and *EQUATION, rectangular, cylindrical or spherical.
// Axes that coincide with the global ones are dropped: such nodes need no equations.
NodeAxes read_transforms(PlacedDeck& deck) {
  NodeAxes result;
  for (const auto& at : deck.blocks("TRANSFORM")) {
    const LocalAxes axes = transform_axes(deck, at);
    for (const Index node : deck.node_list({at.block->keyword.get("NSET"), at.block->keyword.where}, at.place)) {
      const Eigen::Matrix3d local = axes.at(deck.mesh.nodes.col(node));
      if (!local.isIdentity(1e-14)) result[node] = local;
    }
  }
  return result;
}

// A node with axes of its own is held in all its directions at once, so that its equations are formed together; what
// load cases move, hold besides or let go becomes degrees of freedom of a local node.
void read_boundaries(PlacedDeck& deck, const NodeAxes& axes, const SupportHistory& history, Kinematics& motions) {
  std::map<Index, TurnedSupport> turned;
  const auto& varying = history.varying();
  for (const auto& [dof, hold] : history.of_model())
    if (!deck.of_abaqus() && motions.is_mean(dof.node))
      deck.notes.add(
          deck.problems.location(hold.where), "*BOUNDARY on the reference node of *DISTRIBUTING",
          "the mean motion of the coupled nodes is held, as in Abaqus; CalculiX solves as if the node were free",
          DeckNoteKind::doubtful);
  for (const auto& [dof, hold] : history.of_model()) {
    if (axes.contains(dof.node)) {
      auto& support = turned.try_emplace(dof.node, TurnedSupport{hold.name}).first->second;
      support.held[static_cast<std::size_t>(dof.direction)] = true;
      continue;
    }
    motions.hold(hold.name, dof.node, dof.direction);
    if (varying.contains(dof)) motions.move(dof);
  }
  for (const auto& dof : varying)
    if (axes.contains(dof.node)) {
      auto& support = turned.try_emplace(dof.node, TurnedSupport{}).first->second;
      support.varying[static_cast<std::size_t>(dof.direction)] = true;
    }
  for (const auto& [node, support] : turned)
    if (support.varying == Directions{})
      motions.hold(support.name, node, axes.at(node), support.held);
    else
      hold_local_node(deck, node, axes.at(node), support, motions);
}

// A direction in local axes is a sum over global ones, so each term can add up to three.
/// The number of terms, then node or set, direction and coefficient of each; sets of the same size go side by side.
void read_equations(PlacedDeck& deck, const NodeAxes& axes, Kinematics& motions) {
  struct Term {
    std::vector<Index> nodes;
    int direction;
    double coefficient;
  };
  for (const auto& at : deck.blocks("EQUATION")) {
    const auto& lines = at.block->lines;
    for (std::size_t i = 0; i < lines.size();) {
      const DataLine& start = lines[i];
      const auto count = to_integer(start.field(0));
      if (!count || *count < 1 || *count > 1000000 || start.fields.size() > 1) {
        deck.problems.add(start.where, "'" + to_string(start.field(0)) + "' is not a number of terms",
                          "an equation begins with a line that holds only the number of its terms", "correct the line");
        break;
      }
      std::vector<Term> terms;
      bool good = true;
      for (++i; i < lines.size() && terms.size() < static_cast<std::size_t>(*count); ++i)
        for (std::size_t field = 0; field < lines[i].fields.size() && terms.size() < static_cast<std::size_t>(*count);
             field += 3) {
          const auto direction = to_integer(lines[i].field(field + 1));
          const auto coefficient = number_at(lines[i], field + 2, "a coefficient", deck.problems);
          if (!direction || *direction < 1 || *direction > 6) {
            deck.problems.add(lines[i].where, "'" + to_string(lines[i].field(field + 1)) + "' is not a direction",
                              "*EQUATION expects a node or set, a direction (1 to 6) and a coefficient",
                              "correct the line");
            good = false;
          }
          good = good && coefficient.has_value();
          terms.push_back({deck.node_list({lines[i].field(field), lines[i].where}, at.place),
                           direction ? static_cast<int>(std::clamp<std::int64_t>(*direction, 1, 6)) - 1 : 0,
                           coefficient.value_or(0.0)});
          good = good && !terms.back().nodes.empty();
        }
      if (terms.size() < static_cast<std::size_t>(*count)) {
        deck.problems.add(
            start.where,
            "the equation has " + std::to_string(terms.size()) + " of " + std::to_string(*count) + " terms",
            "the deck ends before the remaining terms", "correct the number or add the terms");
        break;
      }
      if (!good) continue;
      const std::size_t size = terms.front().nodes.size();
      for (const auto& term : terms)
        if (term.nodes.size() != size && term.nodes.size() != 1) {
          deck.problems.add(start.where, "the sets of the equation have different numbers of nodes",
                            "they are paired in order", "use sets of the same size, or single nodes");
          good = false;
        }
      for (std::size_t k = 0; good && k < size; ++k) {
        DofSum equation;
        for (const auto& term : terms)
          append_direction(axes, term.nodes.size() == 1 ? term.nodes.front() : term.nodes[k], term.direction,
                           term.coefficient, equation);
        motions.add_equation("equation." + std::to_string(start.where.line), std::move(equation),
                             dependent_dof(axes, {terms.front().nodes[k], terms.front().direction}));
      }
    }
  }
}

}  // namespace kalfem::abaqus
