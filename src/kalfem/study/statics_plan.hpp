// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/model/statics/solved_load_cases.hpp"

namespace kalfem {

class IssueList;
struct StructureModel;
namespace description {
struct Case;
struct Statics;
}  // namespace description

/// Static load cases of a finite-element substructure, checked and factored.
struct StaticsPlan : StaticsProblem {
  FiniteElementPartPtr part;
};

/// Looks up the nodes, groups and points that `static` names. Problems go to `issues` with their place: names that do
/// not exist, a pressure where there are no faces, and everything that StaticAnalysis refuses.
StaticsPlan make_statics_plan(const description::Case& given, const StructureModel& structure, IssueList& issues);

/// The load cases of a substructure; null where the case has none of it.
const description::Statics* statics_of(const description::Case& given, const std::string& substructure);
/// Groups of the mesh that loads name.
std::vector<std::string> load_groups_of(const description::Statics* statics);

/// What the stresses of a load case add to the stiffness of a part, which is not assembled yet. Throws InvalidInput
/// where there is no such load case and as make_statics_plan() does.
Preload preload_of(const FiniteElementPart& part, const Located<std::string>& load_case,
                   const description::Statics* statics);

}  // namespace kalfem
