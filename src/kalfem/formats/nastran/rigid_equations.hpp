#pragma once

#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {

/// sum of the terms = 0, of which a component of a node, in its own axes, depends.
struct DependentRow {
  NodalDof dependent;  ///< direction in the node's displacement axes
  DofSum terms;
};
using NodeComponents = std::vector<std::pair<Eigen::Index, unsigned>>;

/// Dependent components of a rigid body from its independent ones: with the rigid motion q about the first node and the
/// rows R of all components, u_d = R_d R_i^-1 u_i. Empty where six independent ones do not determine q.
std::vector<DependentRow> rigid_rows(const Building& building, const NodeComponents& independent,
                                     const NodeComponents& dependent);

/// a . (u_B - u_A) = 0 along the line of two nodes; the one component of either that is given depends.
std::optional<DependentRow> rod_row(const Building& building, const NodeComponents& nodes);

/// A weighted link (see WeightedLink) whose components are those of the nodes' own axes, and whose equations are solved
/// for the components `moved` where there are any. Empty where that cannot be.
std::vector<DependentRow> weighted_rows(const Building& building, const WeightedLink& link,
                                        const NodeComponents& moved);

}  // namespace kalfem::nastran
