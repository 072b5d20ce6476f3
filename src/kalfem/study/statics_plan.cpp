// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/statics_plan.hpp"

#include <algorithm>

#include "kalfem/casefile/description.hpp"
#include "kalfem/model/statics/load_places.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

Eigen::Vector3d vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

/// The places of one substructure by the names of the case. Unknown names become issues.
class NamedPlaces {
public:
  NamedPlaces(const FiniteElementPart& part, IssueList& issues)
      : places_(part.elements, part.nodes, part.load_groups), issues_(issues) {}

  void add_load(const d::StaticForce& given, LoadCase& load_case) const {
    const Name& place = given.at;
    if (add_force(places_, place.value, vector(given.force), vector(given.moment), load_case)) return;
    issues_.add(place.location, place.path + ": there is no node or group '" + place.value + "'" + hint(place.value),
                "a load needs something to act on", "name one of `nodes`, a node number or a group of the mesh");
  }

  [[nodiscard]] std::vector<LoadedFace> faces(const Name& place) const {
    auto found = places_.faces(place.value);
    if (found.empty() && !places_.has_group(place.value))
      issues_.add(place.location, place.path + ": there is no group '" + place.value + "'" + hint(place.value),
                  "a pressure needs faces", "name a region of shells or a group of surfaces or nodes");
    else if (found.empty())
      issues_.add(place.location, place.path + ": the group '" + place.value + "' holds no faces",
                  "pressure acts on shells and on the outer faces of solids; of a group of nodes, on faces whose nodes "
                  "are all in it",
                  "name a region of shells or a group that covers whole faces");
    return found;
  }

  /// "tip.z" of a named node.
  [[nodiscard]] std::optional<NodalDof> dof(const std::string& name, const d::Value& value) const {
    if (const auto found = places_.dof(name)) return found;
    const auto dot = name.rfind('.');
    if (dot == std::string::npos || direction_index(name.substr(dot + 1)) < 0)
      issues_.add(value.location, value.path + ": '" + name + "' has no direction", "a displacement is along one",
                  "write node.x, y, z, rx, ry or rz");
    else
      issues_.add(value.location, value.path + ": there is no node '" + name.substr(0, dot) + "'" + hint(name), "",
                  "define it under `nodes`");
    return std::nullopt;
  }

  [[nodiscard]] std::string hint(const std::string& name) const { return places_.hint(name); }

private:
  LoadPlaces places_;
  IssueList& issues_;
};

LoadCase load_case_of(const std::string& name, const d::StaticCase& given, const NamedPlaces& places) {
  LoadCase load_case{.name = name, .gravity = vector(given.gravity)};
  if (const auto& rotation = given.rotation)
    load_case.rotation = Rotation{vector(rotation->axis), vector(rotation->about), rotation->speed};
  for (const auto& force : given.forces) places.add_load(force, load_case);
  for (const auto& pressure : given.pressures)
    load_case.pressures.push_back({places.faces(pressure.on), pressure.pressure});
  for (const auto& [dof_name, value] : given.displacements)
    if (const auto dof = places.dof(dof_name, value))
      load_case.imposed.push_back({*dof, checked_number(value, dof->direction < 3 ? "m" : "rad")});
  return load_case;
}

/// The load cases of the case file, then those of the deck, which must have names of their own.
std::vector<LoadCase> load_cases_of(const d::Statics& given, const FiniteElementPart& part, const NamedPlaces& places,
                                    IssueList& issues) {
  std::vector<LoadCase> cases;
  for (const auto& [name, each] : given.cases) cases.push_back(load_case_of(name, each.value, places));
  if (!given.deck_cases.value) return cases;
  if (part.deck_cases.empty())
    issues.add(given.deck_cases.location, given.deck_cases.path + ": '" + part.name + "' has no load cases of a deck",
               "read are static steps of Abaqus and CalculiX, and the loads that subcases of Nastran choose",
               "describe the loads under `cases`");
  for (const auto& load_case : part.deck_cases) {
    if (std::ranges::find(cases, load_case.name, &LoadCase::name) != cases.end())
      issues.add(given.deck_cases.location,
                 given.deck_cases.path + ": the deck too has a load case '" + load_case.name + "'",
                 "names must be unique", "rename the one under `cases`");
    cases.push_back(load_case);
  }
  return cases;
}

std::vector<NamedNode> reported_points(const d::Statics& given, const FiniteElementPart& part,
                                       const NamedPlaces& places, IssueList& issues) {
  if (given.points.empty()) return part.nodes;
  std::vector<NamedNode> points;
  for (const auto& point : given.points)
    if (const auto named = std::ranges::find(part.nodes, point.value, &NamedNode::name); named != part.nodes.end())
      points.push_back(*named);
    else
      issues.add(point.location, point.path + ": there is no node '" + point.value + "'" + places.hint(point.value),
                 "displacements are reported at named nodes", "define it under `nodes`");
  return points;
}

FiniteElementPartPtr loaded_part(const d::Statics& given, const StructureModel& structure) {
  std::vector<std::string> known;
  for (const auto& elements : structure.finite_elements) {
    if (elements.part->name == given.substructure.value) return elements.part;
    known.push_back(elements.part->name);
  }
  const auto& [name, location, path] = given.substructure;
  throw InvalidInput(
      Issue{location, path + ": there is no finite-element substructure '" + name + "'" + did_you_mean(name, known),
            "stresses need elements", "name a substructure with finite_elements"});
}

}  // namespace

const d::Statics* statics_of(const d::Case& given, const std::string& substructure) {
  const bool has = given.statics && given.statics->value.substructure.value == substructure;
  return has ? &given.statics->value : nullptr;
}

std::vector<std::string> load_groups_of(const d::Statics* statics) {
  std::vector<std::string> groups;
  if (!statics) return groups;
  for (const auto& [name, each] : statics->cases) {
    for (const auto& force : each.value.forces) groups.push_back(force.at.value);
    for (const auto& pressure : each.value.pressures) groups.push_back(pressure.on.value);
  }
  return groups;
}

Preload preload_of(const FiniteElementPart& part, const Name& load_case, const d::Statics* statics) {
  IssueList issues;
  std::vector<LoadCase> cases;
  if (statics) cases = load_cases_of(*statics, part, NamedPlaces(part, issues), issues);
  issues.raise();
  const auto found = std::ranges::find(cases, load_case.value, &LoadCase::name);
  if (found == cases.end())
    throw InvalidInput(
        Issue{load_case.location,
              load_case.path + ": `static` has no load case '" + load_case.value + "' of '" + part.name + "'",
              "a preload is the stress of a static load case", "describe it under static.cases"});
  return preload_of(part.elements, *found);
}

StaticsPlan make_statics_plan(const d::Case& given, const StructureModel& structure, IssueList& issues) {
  const d::Statics& statics = given.statics->value;
  StaticsPlan plan{{}, loaded_part(statics, structure)};
  const NamedPlaces places(*plan.part, issues);
  auto cases = load_cases_of(statics, *plan.part, places, issues);
  plan.points = reported_points(statics, *plan.part, places, issues);
  if (issues.empty()) plan.analysis = std::make_shared<const StaticAnalysis>(plan.part->elements, std::move(cases));
  return plan;
}

}  // namespace kalfem
