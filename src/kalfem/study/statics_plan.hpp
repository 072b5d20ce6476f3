#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem {

class IssueList;
struct StructureModel;
namespace description {
struct Case;
}

/// Static load cases of a finite-element substructure, checked and factored.
struct StaticsPlan {
  FiniteElementPartPtr part;
  std::shared_ptr<const StaticAnalysis> analysis;
  std::vector<NamedNode> points;  ///< whose displacement and stress are reported
};

/// Looks up the nodes, groups and points that `static` names. Problems go to `issues` with their place: names that do not
/// exist, a pressure where there are no faces, and everything that StaticAnalysis refuses.
StaticsPlan make_statics_plan(const description::Case& given, const StructureModel& structure, IssueList& issues);

/// Groups of a substructure's mesh that its static loads name.
std::vector<std::string> load_groups_of(const description::Case& given, const std::string& substructure);

}  // namespace kalfem
