// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/statics_plan.hpp"

#include <algorithm>
#include <charconv>
#include <map>

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;
using Eigen::Index;

Eigen::Vector3d vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

/// The nodes and faces that loads name, of one substructure. Unknown names become issues.
class LoadPlaces {
public:
  LoadPlaces(const FiniteElementPart& part, IssueList& issues)
      : part_(part), mesh_(part.elements.mesh), finder_(mesh_), issues_(issues) {}

  /// Nodes with the part of a load that each takes: a named node, a node number, a group of lines or surfaces, or a
  /// group of nodes, which share it equally.
  [[nodiscard]] std::map<Index, double> shares(const Name& place) const {
    if (const auto named = std::ranges::find(part_.nodes, place.value, &NamedNode::name); named != part_.nodes.end())
      return {{named->node, 1.0}};
    if (const auto cells = part_.load_groups.find(place.value); cells != part_.load_groups.end())
      return uniform_shares(mesh_, cells->second);
    if (const auto set = mesh_.node_sets.find(place.value); set != mesh_.node_sets.end()) {
      std::map<Index, double> equal;
      for (const auto node : set->second) equal[node] = 1.0 / static_cast<double>(set->second.size());
      return equal;
    }
    if (const Index node = numbered(place.value); node >= 0) return {{node, 1.0}};
    issues_.add(place.location, place.path + ": there is no node or group '" + place.value + "'" + hint(place.value),
                "a load needs something to act on", "name one of `nodes`, a node number or a group of the mesh");
    return {};
  }

  [[nodiscard]] std::vector<LoadedFace> faces(const Name& place) const {
    std::vector<LoadedFace> found;
    const auto cells = part_.load_groups.find(place.value);
    const auto set = mesh_.node_sets.find(place.value);
    if (cells != part_.load_groups.end()) found = faces_of_cells(part_.elements, cells->second);
    if (found.empty() && set != mesh_.node_sets.end()) found = faces_between_nodes(part_.elements, set->second);
    if (found.empty() && cells == part_.load_groups.end() && set == mesh_.node_sets.end())
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
    const auto dot = name.rfind('.');
    const int direction = dot == std::string::npos ? -1 : direction_index(name.substr(dot + 1));
    const auto named = std::ranges::find(part_.nodes, name.substr(0, dot), &NamedNode::name);
    if (direction < 0)
      issues_.add(value.location, value.path + ": '" + name + "' has no direction", "a displacement is along one",
                  "write node.x, y, z, rx, ry or rz");
    else if (named == part_.nodes.end())
      issues_.add(value.location, value.path + ": there is no node '" + name.substr(0, dot) + "'" + hint(name), "",
                  "define it under `nodes`");
    else
      return NodalDof{named->node, direction};
    return std::nullopt;
  }

  [[nodiscard]] std::string hint(const std::string& name) const {
    std::vector<std::string> known;
    for (const auto& node : part_.nodes) known.push_back(node.name);
    for (const auto& [group, nodes] : mesh_.node_sets) known.push_back(group);
    for (const auto& [region, property] : part_.elements.properties) known.push_back(region);
    return did_you_mean(name.substr(0, name.rfind('.')), known);
  }

private:
  [[nodiscard]] Index numbered(const std::string& word) const {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    return error == std::errc{} && end == word.data() + word.size() ? finder_.find(number) : -1;
  }

  const FiniteElementPart& part_;
  const Mesh& mesh_;
  NodeFinder finder_;
  IssueList& issues_;
};

LoadCase load_case_of(const std::string& name, const d::StaticCase& given, const LoadPlaces& places) {
  LoadCase load_case{.name = name, .gravity = vector(given.gravity)};
  if (const auto& rotation = given.rotation)
    load_case.rotation = Rotation{vector(rotation->axis), vector(rotation->about), rotation->speed};
  for (const auto& force : given.forces)
    for (const auto& [node, share] : places.shares(force.at))
      load_case.loads.push_back({node, share * vector(force.force), share * vector(force.moment)});
  for (const auto& pressure : given.pressures)
    load_case.pressures.push_back({places.faces(pressure.on), pressure.pressure});
  for (const auto& [dof_name, value] : given.displacements)
    if (const auto dof = places.dof(dof_name, value))
      load_case.imposed.push_back({*dof, checked_number(value, dof->direction < 3 ? "m" : "rad")});
  return load_case;
}

/// The load cases of the case file, then those of the deck, which must have names of their own.
std::vector<LoadCase> load_cases_of(const d::Statics& given, const FiniteElementPart& part, const LoadPlaces& places,
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

std::vector<NamedNode> reported_points(const d::Statics& given, const FiniteElementPart& part, const LoadPlaces& places,
                                       IssueList& issues) {
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
  if (statics) cases = load_cases_of(*statics, part, LoadPlaces(part, issues), issues);
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
  StaticsPlan plan{.part = loaded_part(statics, structure)};
  const LoadPlaces places(*plan.part, issues);
  auto cases = load_cases_of(statics, *plan.part, places, issues);
  plan.points = reported_points(statics, *plan.part, places, issues);
  if (issues.empty()) plan.analysis = std::make_shared<const StaticAnalysis>(plan.part->elements, std::move(cases));
  return plan;
}

}  // namespace kalfem
