// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/identification/structure.hpp"

/// Rigid joints of finite-element substructures: two groups of nodes that lie at the same places and move as one. The
/// joined nodes share their degrees of freedom (primal assembly), so nothing is added between them.
namespace kalfem {

/// Groups of a substructure that joints name, without its name.
std::vector<Name> joined_groups(const description::Case& given, const std::string& substructure);

/// Checks what needs no mesh: joined substructures that do not exist, have no finite elements, are the same one, or
/// have modal damping of their own, whose modes are none of the joined structure. Problems go to `issues` with their
/// place.
void check_joints(const description::Case& given, IssueList& issues);

/// Pairs the nodes of each joint, which check_joints() accepts, by their places. Degrees of freedom that both nodes
/// have are shared; a warning tells of rotations that only one has. Problems go to `issues` with their place: nodes
/// without a partner within the tolerance, motions that only one of two partners can make.
std::vector<SharedDof> make_joints(const description::Case& given, const StructureModel& structure,
                                   std::vector<std::string>& warnings, IssueList& issues);

}  // namespace kalfem
