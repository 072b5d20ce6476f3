// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// Nodes of a substructure's named node, or of a group of its mesh; empty if there is none of that name.
std::vector<Eigen::Index> nodes_of_group(const FiniteElementPart& part, const std::string& name);

/// All names that nodes_of_group() knows.
std::vector<std::string> groups_of_nodes(const FiniteElementPart& part);

/// Whether a support holds this motion.
bool is_held(const FiniteElementModel& model, const NodalDof& dof);

}  // namespace kalfem
