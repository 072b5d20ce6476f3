#pragma once

#include <set>
#include <unordered_map>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/model/assembly/constraint_elimination.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem::abaqus {

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
  void hold(const std::string& name, Index node, int direction);
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
  [[nodiscard]] bool is_slave(const NodalDof& dof) const { return leader_.contains(dof); }

  FiniteElementModel& model_;
  DeckNotes& notes_;
  Problems& problems_;
  std::vector<Link> links_;
  std::map<NodalDof, Index> leader_;                  ///< master of a slave's degree of freedom
  std::unordered_map<Index, std::set<Index>> above_;  ///< masters of a slave
  std::vector<Weighted> weighted_;
  std::vector<Equation> equations_;
  std::map<NodalDof, std::string> held_;
  std::set<NodalDof> fixed_;
};

}  // namespace kalfem::abaqus
