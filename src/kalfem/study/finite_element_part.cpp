// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/finite_element_part.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/reduction/free_interface.hpp"
#include "kalfem/study/finite_element_builder.hpp"
#include "kalfem/study/node_groups.hpp"
#include "kalfem/study/statics_plan.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
namespace d = description;

/// Motions that the boundary must keep, for a place such as "p1", "p1.rx" or a group of nodes.
struct BoundaryPlace {
  Located<std::string> place;
  std::vector<NodalDof> dofs;
  bool is_group = false;
};

std::vector<NodalDof> translations_of(Index node) { return {{node, 0}, {node, 1}, {node, 2}}; }

/// "p1": the translations of the node; "p1.rx": that motion, and its node's translations where `whole_node` is set.
/// Empty where there is no such node.
std::vector<NodalDof> dofs_of(const FiniteElementPart& part, const std::string& place, bool whole_node) {
  const auto dot = place.find('.');
  const auto found = std::ranges::find(part.nodes, place.substr(0, dot), &NamedNode::name);
  if (found == part.nodes.end()) return {};
  if (dot == std::string::npos) return translations_of(found->node);
  const int direction = direction_index(place.substr(dot + 1));
  if (direction < 0) return {};
  auto dofs = whole_node ? translations_of(found->node) : std::vector<NodalDof>{};
  if (!whole_node || direction >= 3) dofs.push_back({found->node, direction});
  return dofs;
}

/// Each attached node keeps its three translations: forces along one of them alone would leave the rest to move freely
/// in the fixed-interface modes.
std::vector<BoundaryPlace> attached_boundary(const FiniteElementPart& part, const d::Substructure& given,
                                             const std::vector<std::string>& attached) {
  std::vector<BoundaryPlace> boundary;
  const auto add = [&](const std::string& place) { boundary.push_back({{place}, dofs_of(part, place, true)}); };
  for (const auto& point : attached) {
    const auto weighted = std::ranges::find(given.points, point, &std::pair<std::string, Named<double>>::first);
    if (weighted == given.points.end())
      add(point);
    else
      for (const auto& [place, weight] : weighted->second) add(place);
  }
  return boundary;
}

/// All motions of the nodes of a group, those that the nodes do not have among them.
BoundaryPlace group_boundary(const FiniteElementPart& part, const Name& group) {
  BoundaryPlace boundary{group, {}, true};
  for (const Index node : nodes_of_group(part, group.value))
    for (int direction = 0; direction < 6; ++direction) boundary.dofs.push_back({node, direction});
  return boundary;
}

std::vector<BoundaryPlace> given_boundary(const FiniteElementPart& part, const d::Reduction& given) {
  std::vector<BoundaryPlace> boundary;
  IssueList issues;
  for (const auto& place : given.boundary) {
    boundary.push_back({place, dofs_of(part, place.value, false)});
    if (boundary.back().dofs.empty()) boundary.back() = group_boundary(part, place);
    if (boundary.back().dofs.empty())
      issues.add(place.location,
                 place.path + ": there is no node or group '" + place.value + "'" +
                     did_you_mean(place.value, groups_of_nodes(part)),
                 "the boundary must consist of named nodes", "name one of the `nodes`, node.direction, or a group");
  }
  issues.raise();
  return boundary;
}

/// Boundary nodes at which the substructure is joined to others.
std::vector<BoundaryPlace> joined_boundary(const FiniteElementPart& part, const std::vector<Name>& groups) {
  std::vector<BoundaryPlace> boundary;
  IssueList issues;
  for (const auto& group : groups) {
    boundary.push_back(group_boundary(part, group));
    if (boundary.back().dofs.empty())
      issues.add(group.location,
                 group.path + ": substructure '" + part.name + "' has no group of nodes '" + group.value + "'" +
                     did_you_mean(group.value, groups_of_nodes(part)),
                 "a joint needs nodes", "name a group of its mesh, a node set of its deck, or one of its `nodes`");
  }
  issues.raise();
  return boundary;
}

std::vector<NodalDof> all_dofs(const std::vector<BoundaryPlace>& boundary) {
  std::vector<NodalDof> dofs;
  for (const auto& each : boundary) dofs.insert(dofs.end(), each.dofs.begin(), each.dofs.end());
  return dofs;
}

/// Sorts the motions that the boundary must keep. An independent degree of freedom becomes a coordinate of the
/// boundary. A motion that links express by other nodes follows these exactly, and a fixed one does not move; the user
/// gets a warning for motions named in the case.
class BoundaryMaker {
public:
  explicit BoundaryMaker(DescribedPart& described)
      : part_(described.part), warnings_(described.warnings), rows_(part_.assembled.expansion) {}

  /// `is_given`: named by the user, so the place must be able to move. Places of connectors and forces are checked with
  /// these.
  void add(const BoundaryPlace& place, bool is_given, IssueList& issues) {
    std::vector<std::string> still, following;
    for (const auto& dof : place.dofs) {
      const std::string name = dof_name(part_.elements.mesh, dof);
      if (part_.assembled.find(dof) >= 0) {
        if (std::ranges::find(part_.boundary, name) == part_.boundary.end()) part_.boundary.push_back(name);
      } else {
        (moves(dof) ? following : still).push_back(direction_names[static_cast<std::size_t>(dof.direction)]);
      }
    }
    if (is_given && still.size() == place.dofs.size()) refuse(place, issues);
    if (place.is_group) return;  // what their nodes cannot do is no surprise
    if (is_given && !following.empty())
      warnings_.push_back("the boundary has no independent coordinate for " + place.place.value + " along " +
                          listed(following) + ": links express it exactly by the other boundary nodes");
    if (is_given && !still.empty() && still.size() < place.dofs.size())
      warnings_.push_back("the boundary node " + place.place.value + " cannot move along " + listed(still));
  }

private:
  [[nodiscard]] bool moves(const NodalDof& dof) const {
    return rows_.innerVector(6 * dof.node + dof.direction).nonZeros() > 0;
  }

  static std::string listed(const std::vector<std::string>& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
  }

  void refuse(const BoundaryPlace& place, IssueList& issues) const {
    const bool held =
        std::ranges::any_of(place.dofs, [&](const NodalDof& dof) { return is_held(part_.elements, dof); });
    issues.add(place.place.location, place.place.path + ": '" + place.place.value + "' cannot move",
               held ? "a support fixes it, so nothing can act there"
                    : "it has no element, spring or mass, or depends on fixed nodes",
               "name a node or direction that can move");
  }

  FiniteElementPart& part_;
  std::vector<std::string>& warnings_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows_;  ///< motion of each nodal degree of freedom by the free ones
};

/// Whether connectors or forces act on points other than the grounds of the substructure. Points that do not exist or
/// do not move are refused with their connectors and forces.
bool touches_nodes(const d::Substructure& given, const std::vector<std::string>& attached) {
  return std::ranges::any_of(attached, [&](const std::string& point) {
    return point != "ground" && std::ranges::find(given.grounds, point) == given.grounds.end();
  });
}

/// A reduction needs at least one degree of freedom at its boundary.
void require_boundary(const FiniteElementPart& part, const Located<d::Reduction>& reduction) {
  if (!part.boundary.empty()) return;
  throw InvalidInput(Issue{reduction.location,
                           reduction.path + ": the reduction of '" + part.name + "' has no boundary",
                           "no connector or force is attached to the substructure, and `boundary` lists no node",
                           "list the nodes to keep under `boundary`, or remove `reduction` to use the full model"});
}

void add_weighted_points(const d::Substructure& given, LinearModel& model) {
  for (const auto& [point, weights] : given.points) {
    DofCombination sum;
    for (const auto& [place, weight] : weights) {
      const auto found = model.points.find(place);
      if (found == model.points.end())
        throw InvalidInput(
            "point '" + point + "' uses '" + place + "', which is not a degree of freedom of a named node",
            "a point is a weighted sum of node.direction", "define the node under `nodes`");
      for (const auto& [dof, coefficient] : found->second) sum[dof] += weight * coefficient;
    }
    model.points[point] = sum;
  }
}

/// A gauge on the side of a shell measures bending by half the thickness, which must then be known.
void check_thickness_at_gauges(const FiniteElementPart& part, const std::vector<std::string>& parameters) {
  IssueList issues;
  for (const auto& gauge : part.gauges) {
    if (gauge.surface != Layer::top && gauge.surface != Layer::bottom) continue;
    for (const auto& [region, cells] : part.elements.mesh.regions)
      if (std::ranges::find(cells, gauge.cell) != cells.end() &&
          std::ranges::find(parameters, region + ".thickness") != parameters.end())
        issues.add({},
                   "strain gauge '" + gauge.name + "' stands on a side of '" + region + "', whose thickness is unknown",
                   "its strain by bending is taken at the stated thickness",
                   "hold the thickness fixed, or write surface: middle");
  }
  issues.raise();
}

/// Connectors and excitations may name a ground at which no spring ends.
void add_grounds(const d::Substructure& given, LinearModel& model) {
  std::vector<std::string> names{"ground"};
  names.insert(names.end(), given.grounds.begin(), given.grounds.end());
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.size());
  for (const auto& name : names)
    if (std::ranges::find(model.grounds, name, &GroundCoupling::ground) == model.grounds.end())
      model.grounds.push_back({name, none, none});
}

UsedGroups used_groups(const PartUses& uses) {
  return {load_groups_of(uses.statics), uses.joined, uses.statics && uses.statics->deck_cases.value};
}

}  // namespace

DescribedPart make_finite_element_part(const std::string& name, const d::Substructure& given, const PartUses& uses,
                                       DeckFiles& decks) {
  DescribedPart described;
  FiniteElementPart& part = described.part;
  part.name = name;
  part.damping = {{given.damping.mass_factor, given.damping.stiffness_factor},
                  {given.damping.modal, given.damping.modal_up_to}};
  auto [elements, nodes, gauges, notes, groups, deck_cases, deck_preload] =
      part.times.measure("read", [&] { return build_finite_elements(name, given, used_groups(uses), decks); });
  part.elements = std::move(elements);
  part.nodes = std::move(nodes);
  part.gauges = std::move(gauges);
  part.load_groups = std::move(groups);
  part.deck_cases = std::move(deck_cases);
  described.notes = std::move(notes);
  const bool is_given = given.reduction && !given.reduction->value.boundary.empty();
  const auto boundary =
      is_given ? given_boundary(part, given.reduction->value) : attached_boundary(part, given, uses.attached);
  const auto joined = joined_boundary(part, uses.joined);
  if (given.preload || deck_preload) {
    auto preload =
        given.preload ? preload_of(part, *given.preload, uses.statics) : preload_of(part.elements, *deck_preload);
    part.preload_stiffness = std::move(preload.stiffness);
    const std::string load_case = given.preload ? given.preload->value : deck_preload->name;
    if (!preload.ignored.empty()) described.warnings.push_back(ignored_preload(load_case, preload.ignored));
  }
  try {
    check_thickness_at_gauges(part, uses.parameters);
    auto kept = all_dofs(boundary);
    std::ranges::move(all_dofs(joined), std::back_inserter(kept));
    assemble_part(part, {.parameters = {uses.parameters.begin(), uses.parameters.end()},
                         .independent = kept,
                         .at_present_values = uses.at_present_values});
    add_grounds(given, part.full);
    add_weighted_points(given, part.full);
    if (!given.damping.modal.empty())
      part.times.measure("damping", [&] {
        add_modal_damping(part.full, given.damping.modal, {.up_to = given.damping.modal_up_to}, part.factor.get());
      });
  } catch (const InvalidInput& error) {
    IssueList issues;
    issues.add(error, given.finite_elements->location());
    issues.raise();
  }
  for (const auto& finding : {units_finding(part.elements), coincident_elements_finding(part.elements)})
    if (finding) described.warnings.push_back(finding->what + ": " + finding->why + "; " + finding->fix);
  if (part.full.mass.norm() == 0.0 && uses.statics == nullptr)
    described.warnings.push_back("'" + name +
                                 "' has no mass, and so no natural frequencies; give its materials a density");
  IssueList issues;
  BoundaryMaker maker(described);
  for (const auto& place : boundary) maker.add(place, is_given, issues);
  for (const auto& place : joined) maker.add(place, true, issues);
  issues.raise();
  if (given.reduction && !touches_nodes(given, uses.attached)) require_boundary(part, *given.reduction);
  return described;
}

ReductionRequest reduction_request(const std::optional<Located<d::Reduction>>& given) {
  if (!given) return {};
  const d::Reduction& reduction = given->value;
  return {reduction.method,
          {.count = reduction.modes, .cutoff = reduction.up_to, .effective_mass = reduction.effective_mass},
          reduction.augmentation_vectors};
}

}  // namespace kalfem
