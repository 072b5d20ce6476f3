// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/statics.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/finite_element_substructure.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/model/statics/load_places.hpp"
#include "kalfem/model/statics/solved_load_cases.hpp"

namespace kalfem {

namespace {

/// Loads of the caller as a load case; what is wrong becomes an issue with its place.
class LoadReader {
public:
  LoadReader(const FiniteElementPart& part, IssueList& issues)
      : places_(part.elements, part.nodes, part.elements.mesh.regions), issues_(issues) {}

  LoadCase read(std::size_t number, const StaticLoads& given) {
    case_ = "cases[" + std::to_string(number) + "] '" + given.name + "': ";
    if (given.name.empty()) refuse("it has no name", "results are found by it", "give one");
    LoadCase load_case{.name = given.name, .gravity = given.gravity, .rotation = given.rotation, .imposed = {}};
    check("gravity", given.gravity);
    if (given.rotation && !std::isfinite(given.rotation->speed)) refuse("rotation: its speed is not finite", "", "");
    for (std::size_t i = 0; i < given.forces.size(); ++i) add_force_of(i, given.forces[i], load_case);
    for (std::size_t i = 0; i < given.pressures.size(); ++i) add_pressure_of(i, given.pressures[i], load_case);
    for (const auto& [dof, value] : given.displacements) add_displacement(dof, value, load_case);
    return load_case;
  }

private:
  void refuse(const std::string& what, const std::string& why, const std::string& fix) {
    issues_.add({}, case_ + what, why, fix);
  }

  void check(const std::string& place, const Eigen::Vector3d& values) {
    if (!values.allFinite()) refuse(place + ": a component is not finite", "loads are numbers", "");
  }

  void add_force_of(std::size_t i, const AppliedForce& given, LoadCase& load_case) {
    const std::string place = "forces[" + std::to_string(i) + "]";
    check(place, given.force);
    check(place, given.moment);
    if (!add_force(places_, given.at, given.force, given.moment, load_case))
      refuse(place + ": there is no node or group '" + given.at + "'" + places_.hint(given.at),
             "a load needs something to act on", "name a node, by node() or its number, or a group of the mesh");
  }

  void add_pressure_of(std::size_t i, const AppliedPressure& given, LoadCase& load_case) {
    const std::string place = "pressures[" + std::to_string(i) + "]: ";
    const auto faces = places_.faces(given.on);
    if (!std::isfinite(given.pressure)) refuse(place + "it is not finite", "loads are numbers", "");
    if (!faces.empty())
      load_case.pressures.push_back({faces, given.pressure});
    else if (places_.has_group(given.on))
      refuse(place + "the group '" + given.on + "' holds no faces",
             "pressure acts on shells, and on outer faces of solids whose nodes are all in the group",
             "name a region of shells or a set of nodes that covers whole faces");
    else
      refuse(place + "there is no group '" + given.on + "'" + places_.hint(given.on), "a pressure needs faces",
             "name a region of shells or a set of nodes");
  }

  void add_displacement(const std::string& name, double value, LoadCase& load_case) {
    const std::string place = "displacements: ";
    const auto dof = places_.dof(name);
    if (!std::isfinite(value)) refuse(place + "'" + name + "' is not finite", "", "");
    if (dof)
      load_case.imposed.push_back({*dof, value});
    else
      refuse(place + "there is no motion '" + name + "'" + places_.hint(name), "a displacement is along one direction",
             "write node.x, y, z, rx, ry or rz of a named node");
  }

  LoadPlaces places_;
  IssueList& issues_;
  std::string case_;
};

std::vector<LoadCase> read_cases(const FiniteElementPart& part, const std::vector<StaticLoads>& given,
                                 const std::vector<LoadCase>& deck_cases) {
  IssueList issues;
  std::vector<LoadCase> cases;
  LoadReader reader(part, issues);
  if (given.empty() && deck_cases.empty())
    issues.add({}, "cases: the list is empty", "there is nothing to solve", "give at least one load case");
  for (std::size_t i = 0; i < given.size(); ++i) cases.push_back(reader.read(i, given[i]));
  cases.insert(cases.end(), deck_cases.begin(), deck_cases.end());
  for (std::size_t i = 0; i < cases.size(); ++i)
    if (std::find_if(cases.begin(), cases.begin() + static_cast<std::ptrdiff_t>(i), [&](const LoadCase& each) {
          return each.name == cases[i].name;
        }) != cases.begin() + static_cast<std::ptrdiff_t>(i))
      issues.add({}, "cases: there are two load cases '" + cases[i].name + "'", "names must be unique",
                 "give each its own");
  issues.raise();
  return cases;
}

SupportReaction reaction_of(const std::string& name, const Resultant& sum) {
  return {name, sum.force, sum.moment, sum.centre};
}

StaticsCase case_of(const FiniteElementPart& part, const SolvedLoadCase& solved) {
  const auto& mesh = part.elements.mesh;
  const auto& solution = solved.solution;
  StaticsCase result{.name = solution.load_case,
                     .displacements = solution.displacements.reshaped(6, mesh.node_count()),
                     .nodes = {},
                     .peaks = {},
                     .reactions = {},
                     .applied = reaction_of("loads", solution.applied),
                     .reaction_sum = reaction_of("sum of reactions", solution.reaction_sum),
                     .imbalance = solution.imbalance};
  for (const auto& [name, node, displacement, stress] : solved.points) {
    auto& point = result.nodes.emplace_back(NodeStatics{name, displacement});
    if (!stress) continue;
    point.stress = stress->stress;
    point.von_mises = von_mises(stress->stress);
    point.layer = stress->layer;
  }
  for (const auto& peak : solved.peaks)
    result.peaks.push_back({peak.region, peak.value, mesh.cells[static_cast<std::size_t>(peak.cell)].id,
                            mesh.node_ids[static_cast<std::size_t>(peak.node)], peak.layer, peak.of_beam});
  for (const auto& [name, sum] : solution.reactions) result.reactions.push_back(reaction_of(name, sum));
  return result;
}

}  // namespace

StaticsResult statics(const FiniteElements& elements, const std::vector<StaticLoads>& cases,
                      const std::vector<LoadCase>& deck_cases) {
  const FiniteElementPart part = make_full_part(elements);
  const SolvedLoadCases solved =
      statics({std::make_shared<const StaticAnalysis>(part.elements, read_cases(part, cases, deck_cases)), part.nodes});
  StaticsResult result{.cases = {}, .warnings = solved.warnings};
  for (const auto& each : solved.cases) result.cases.push_back(case_of(part, each));
  return result;
}

}  // namespace kalfem
