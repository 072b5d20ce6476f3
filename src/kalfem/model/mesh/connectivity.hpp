#pragma once

#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Parts of a model joined by cells that have a property, rigid links, constraints and springs between nodes: the nodes
/// of each part, ascending, the largest part first. Nodes that nothing touches belong to no part. A spring to ground
/// and a support join nothing.
std::vector<std::vector<Eigen::Index>> connected_parts(const FiniteElementModel& model);

/// Throws InvalidInput where the model falls into several parts: names each by its number of nodes, one node and the
/// region that it lies in.
void require_connected(const FiniteElementModel& model);

/// Pairs of nodes (by index, the lower first) that are nearer to each other than `tolerance` [m], of those marked; by a
/// hash of a grid, in a time that grows with the number of nodes. Of many nodes at one place, each is paired with at
/// most `most_partners` others.
std::vector<std::pair<Eigen::Index, Eigen::Index>> coincident_nodes(const Eigen::Matrix3Xd& places,
                                                                    const std::vector<bool>& marked, double tolerance,
                                                                    int most_partners = 8);

/// Which of the pairs something joins directly: a cell with a property, a link, constraint, spring, joint or matrix
/// that names both nodes.
std::vector<bool> directly_joined(const FiniteElementModel& model,
                                  const std::vector<std::pair<Eigen::Index, Eigen::Index>>& pairs);

}  // namespace kalfem
