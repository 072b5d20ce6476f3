#pragma once

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Parts of a model joined by cells that have a property, rigid links, constraints and springs between nodes: the nodes
/// of each part, ascending, the largest part first. Nodes that nothing touches belong to no part. A spring to ground
/// and a support join nothing.
std::vector<std::vector<Eigen::Index>> connected_parts(const FiniteElementModel& model);

/// Throws InvalidInput where the model falls into several parts: names each by its number of nodes, one node and the
/// region that it lies in.
void require_connected(const FiniteElementModel& model);

}  // namespace kalfem
