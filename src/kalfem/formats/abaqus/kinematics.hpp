// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <unordered_map>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/model/assembly/constraint_elimination.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem::abaqus {

class SupportHistory;

/// Everything that ties motions of nodes: rigid links, weighted links, equations and supports, which decks let act on
/// the same nodes. Links come first; equations and supports of nodes that follow others are written in the motions of
/// what leads them, and reduced to equations that do not depend on each other.
class Kinematics {
public:
  using Directions = std::array<bool, 6>;

  Kinematics(FiniteElementModel& model, DeckNotes& notes, Problems& problems)
      : model_(model), notes_(notes), problems_(problems) {}

  /// Slaves move as one rigid body with the master.
  void add_link(const std::string& name, Index master, const std::vector<Index>& slaves, const Directions& tied);
  void add_weighted_link(WeightedLink link, const Where& where);
  /// Whether the node takes the mean motion of others.
  [[nodiscard]] bool is_mean(Index node) const { return means_.contains(node); }
  void hold(const std::string& name, Index node, int direction);
  /// A held motion that load cases move: what depends on it stays so.
  void move(const NodalDof& dof) { moved_.insert(dof); }
  /// Holds directions of a node in axes of its own (columns).
  void hold(const std::string& name, Index node, const Eigen::Matrix3d& axes, const Directions& directions);
  /// sum coefficient z = 0, solved for `dependent` where that can be.
  void add_equation(const std::string& name, DofSum terms, std::optional<NodalDof> dependent = std::nullopt);

  /// Writes all of it to the model.
  void store();

private:
  struct Equation {
    std::string name;
    DofSum terms;
    std::optional<NodalDof> dependent;
  };
  struct Link {
    std::string name;
    Index master;
    std::vector<std::pair<Index, Directions>> slaves;
  };
  struct Weighted {
    WeightedLink link;
    MeanMotion mean;
    bool as_equations = false;
  };

  bool leads_to(Index node, Index target) const;
  void expand(const NodalDof& dof, double factor, std::map<NodalDof, double>& terms, int depth = 0) const;
  [[nodiscard]] std::map<NodalDof, double> expanded(const DofSum& terms) const;
  void collect_rows();
  void write_weighted_links(ReducedEquations& rows);
  void store_links();
  void store_fixed();
  [[nodiscard]] bool stays_still(const NodalDof& dof) const { return fixed_.contains(dof) && !moved_.contains(dof); }
  [[nodiscard]] bool is_slave(const NodalDof& dof) const { return leader_.contains(dof); }

  FiniteElementModel& model_;
  DeckNotes& notes_;
  Problems& problems_;
  std::vector<Link> links_;
  std::map<NodalDof, Index> leader_;                  ///< master of a slave's degree of freedom
  std::unordered_map<Index, std::set<Index>> above_;  ///< masters of a slave
  std::vector<Weighted> weighted_;
  std::set<Index> means_;  ///< their followers
  std::vector<Equation> equations_;
  std::map<NodalDof, std::string> held_;
  std::set<NodalDof> fixed_;
  std::set<NodalDof> moved_;  ///< those of them that load cases move
};

/// Supports by their names, nodes of the same directions together.
std::vector<FixedNodes> grouped_supports(const std::map<NodalDof, std::string>& held);

/// A side of an element: corners, then the nodes amid its sides; two corners of an edge.
struct Face {
  std::vector<Index> nodes;
  std::size_t corners = 0;
  Index element = 0;        ///< position in PlacedDeck::elements
  bool from_below = false;  ///< the side of a shell against its normal
  std::string label = {};   ///< S1, ..., SPOS, SNEG
};

/// A surface of *SURFACE with the nodes on it.
struct Surface {
  std::vector<Face> faces;      ///< none where it was given by nodes
  std::vector<Index> nodes;     ///< each once
  std::vector<double> weights;  ///< of the nodes: the area of faces around them, or what was given
};

/// The surface that a keyword at `where` names in a place; a problem where it is missing or of a kind that is not read.
Surface find_surface(PlacedDeck& deck, const std::string& name, int place, const Where& where);
/// The face of an element by its label in *SURFACE; nothing where it has none of this name.
std::optional<Face> find_face(PlacedDeck& deck, Index element, const std::string& label);

/// Axes of nodes that *TRANSFORM turns.
using NodeAxes = std::unordered_map<Index, Eigen::Matrix3d>;
NodeAxes read_transforms(PlacedDeck& deck);

/// Supports of the model; those that differ between load cases are kept apart for these.
void read_boundaries(PlacedDeck& deck, const NodeAxes& axes, const SupportHistory& history, Kinematics& motions);
void read_equations(PlacedDeck& deck, const NodeAxes& axes, Kinematics& motions);
void read_multi_point_constraints(PlacedDeck& deck, Kinematics& motions);
/// *RIGID BODY, *COUPLING, *KINEMATIC COUPLING, *DISTRIBUTING COUPLING.
void read_rigid_bodies(PlacedDeck& deck, Kinematics& motions);
void read_couplings(PlacedDeck& deck, Kinematics& motions);
/// *TIE: nodes of one surface follow the faces of another.
void read_ties(PlacedDeck& deck, const FiniteElementModel& model, Kinematics& motions);

}  // namespace kalfem::abaqus
