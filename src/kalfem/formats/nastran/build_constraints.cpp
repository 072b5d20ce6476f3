// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <set>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/assembly/constraint_elimination.hpp"
#include "kalfem/model/placement.hpp"

namespace kalfem::nastran {
namespace {

constexpr unsigned all_six = 63;

/// Sets that a chosen one stands for, sums followed.
void follow_sums(const std::map<Id, std::vector<Id>>& sums, Id set, std::set<Id>& sets) {
  if (!sets.insert(set).second) return;
  if (const auto sum = sums.find(set); sum != sums.end())
    for (const Id part : sum->second) follow_sums(sums, part, sets);
}

/// Which sets of SPC (MPC) hold: those that the case control chooses; without any case control the only one there is,
/// or the only sum, or else all of them.
std::set<Id> chosen_sets(Building& building, const char* kind, std::optional<Id> choice, bool has_control,
                         const std::set<Id>& present, const std::map<Id, std::vector<Id>>& sums, const Place& first) {
  std::set<Id> sets;
  const auto tell_empty_parts = [&] {
    for (const Id set : sets)
      if (!present.contains(set) && !sums.contains(set) && set != choice)
        building.note(first, std::string(kind) + "ADD with the set " + std::to_string(set),
                      "the set has no cards, so it holds nothing", DeckNoteKind::doubtful);
  };
  if (choice) {
    follow_sums(sums, *choice, sets);
    tell_empty_parts();
    if (std::ranges::none_of(sets, [&](Id set) { return present.contains(set); }))
      building.files.problem(
          {}, std::string(kind) + " = " + std::to_string(*choice) + " of the case control selects a set without cards",
          "the structure would lack these constraints", "add the set or correct the number");
    return sets;
  }
  if (present.empty()) return sets;
  if (has_control) {
    building.note(first, std::string(kind) + " sets in the bulk data", "the case control selects none, so none is used",
                  DeckNoteKind::doubtful);
    return sets;
  }
  if (sums.size() == 1) {
    follow_sums(sums, sums.begin()->first, sets);
    tell_empty_parts();
    return sets;
  }
  if (present.size() > 1)
    building.note(first, std::string(kind) + " sets in the bulk data", "no case control selects one, so all are used",
                  DeckNoteKind::doubtful);
  return present;
}

std::string title_of(const RigidBodyCard& card) { return std::string(card.kind) + " " + std::to_string(card.id); }

class ConstraintBuilder {
public:
  explicit ConstraintBuilder(Building& building) : building_(building) {}
  void hold_nodes();
  void hold_sets(const std::set<Id>& sets);
  void add_mpcs();
  void add_rigid();
  void add_weighted();
  void finish() { equations_.store(building_.model); }

private:
  void hold(const std::string& name, Eigen::Index node, unsigned components, const Place& where);
  template <typename Visit>
  void visit_nodes(const SpcCard& card, const Visit& visit);
  void sort_numbers();
  void hold_all();
  void add_local_nodes();
  void add_local(Eigen::Index node, const Place& where);
  void add_equation(const std::string& name, const DofSum& terms, Eigen::Index node, int component, const Place& where);
  unsigned without_shared(const RigidBodyCard& card, Eigen::Index master, Eigen::Index node, unsigned components);
  bool is_simple(Eigen::Index node, unsigned components) const;
  std::optional<std::vector<std::pair<Eigen::Index, unsigned>>> indices(
      const std::vector<std::pair<Id, unsigned>>& nodes, const std::string& title, const Place& where);
  void add_links(const RigidBodyCard& card, Eigen::Index master,
                 const std::vector<std::pair<Eigen::Index, unsigned>>& dependent);
  bool leads_itself(const RigidBodyCard& card, const NodeComponents& independent, const NodeComponents& dependent);
  void add_rigid_body(const RigidBodyCard& card);

  Building& building_;
  ReducedEquations equations_;
  std::vector<std::pair<Id, Eigen::Index>> by_id_;                 ///< all nodes, ascending
  std::map<std::pair<std::string, unsigned>, std::size_t> fixed_;  ///< place in model.fixed by set and components
  struct Lead {
    Eigen::Index master;
    const RigidBodyCard* card;
  };
  std::map<NodalDof, Lead> leads_;  ///< of components that follow a master
  /// What one card holds of a node, in the node's axes.
  struct Held {
    std::string name;
    Eigen::Index node;
    unsigned components;
    Place where;
  };
  std::vector<Held> asked_;                ///< by all cards, in their order
  std::map<Eigen::Index, unsigned> held_;  ///< of nodes in turned axes, by all cards together
};

/// Whether components of a node mean the same in its own axes and in global ones.
bool ConstraintBuilder::is_simple(Eigen::Index node, unsigned components) const {
  const auto whole = [](unsigned triple) { return triple == 0 || triple == 7; };
  return !building_.is_turned(node) || (whole(components & 7u) && whole(components >> 3));
}

void ConstraintBuilder::add_equation(const std::string& name, const DofSum& terms, Eigen::Index node, int component,
                                     const Place& where) {
  NodalDof preferred{node, component};
  if (building_.is_turned(node)) {
    int strongest = 0;
    building_.motion_axes(node).col(component % 3).cwiseAbs().maxCoeff(&strongest);
    preferred.direction = component / 3 * 3 + strongest;
  }
  // Names of constraints are unique.
  const auto id = building_.model.mesh.node_ids[static_cast<std::size_t>(node)];
  equations_.add(name + ".n" + std::to_string(id) + "." + std::to_string(component + 1), terms, preferred,
                 building_.files.location(where));
}

/// Nodes in turned axes that load cases move, or that some of them hold: their components become degrees of freedom of
/// a local node.
void ConstraintBuilder::add_local_nodes() {
  const auto add = [&](Id id, const Place& where) {
    add_local(building_.node(id, "an enforced motion", where), where);
  };
  for (const auto& card : building_.bulk.spcs)
    if (card.value != 0.0) add(card.nodes.front().first, card.where);
  for (const auto& card : building_.bulk.imposed) add(card.node, card.where);
  const auto has_other = [&](const Subcase& each) { return each.spc != building_.control.chosen.spc; };
  if (std::ranges::none_of(building_.control.subcases, has_other)) return;
  for (const auto& card : building_.bulk.spcs)
    visit_nodes(card, [&](Eigen::Index node) {
      if (!building_.is_scalar(node) && !is_simple(node, card.components)) add_local(node, card.where);
    });
}

void ConstraintBuilder::add_local(Eigen::Index node, const Place& where) {
  if (node < 0 || !building_.is_turned(node) || building_.local_nodes.contains(node)) return;
  auto& mesh = building_.model.mesh;
  const auto local = building_.local_nodes[node] = add_local_node(mesh, node, building_.motion_axes(node));
  for (const auto& constraint : local_motions(mesh, node, local))
    equations_.add(constraint.name, constraint.terms, constraint.terms.front().first, building_.files.location(where));
}

void ConstraintBuilder::hold(const std::string& name, Eigen::Index node, unsigned components, const Place& where) {
  if (building_.is_scalar(node)) components = components == 0 ? 1u : components & 1u;
  if (components == 0)
    return building_.note(where, "supports without components", "they hold nothing", DeckNoteKind::doubtful);
  building_.model.mesh.node_sets[name].push_back(node);
  if (const auto local = building_.local_nodes.find(node); local != building_.local_nodes.end())
    node = local->second;
  else if (building_.is_turned(node))
    held_[node] |= components;
  asked_.push_back({name, node, components, where});
}

/// With the other two translations, or rotations, that one is held with all cards together.
unsigned with_whole_triples(unsigned components, unsigned held) {
  for (const unsigned triple : {7u, 56u})
    if ((components & triple) != 0 && (held & triple) == triple) components |= triple;
  return components;
}

// Components in turned axes are held by equations, all others by supports, grouped by set and components. Where all
// cards together hold all three translations, or rotations, of a node, these are a support in any axes. Each component
// is held once: by the card that names it first.
void ConstraintBuilder::hold_all() {
  std::map<Eigen::Index, unsigned> done;
  for (const auto& [name, node, given, where] : asked_) {
    unsigned components = given;
    const auto held = held_.find(node);
    if (held != held_.end()) {
      components = with_whole_triples(given, held->second) & ~done[node];
      done[node] |= components;
    }
    if (components == 0) continue;
    if (held != held_.end() && !is_simple(node, components)) {
      for (int i = 0; i < 6; ++i)
        if (((components >> i) & 1u) != 0) {
          DofSum terms;
          building_.append(terms, node, i, 1.0);
          add_equation(name, terms, node, i, where);
        }
      continue;
    }
    const auto [place, is_new] = fixed_.try_emplace({name, components}, building_.model.fixed.size());
    if (is_new) {
      FixedNodes fixed{name, {}, {}};
      for (std::size_t i = 0; i < 6; ++i) fixed.directions[i] = ((components >> i) & 1u) != 0;
      building_.model.fixed.push_back(std::move(fixed));
    }
    building_.model.fixed[place->second].nodes.push_back(node);
  }
}

// A THRU range of SPC1 stands for the grid points that exist in it, so it walks through the sorted numbers. A single
// number must exist.
template <typename Visit>
void ConstraintBuilder::visit_nodes(const SpcCard& card, const Visit& visit) {
  for (const auto& range : card.nodes) {
    if (range.single) {
      const auto node = building_.node(range.first, "SPC " + std::to_string(card.set), card.where);
      if (node >= 0) visit(node);
      continue;
    }
    auto place = std::ranges::lower_bound(by_id_, range.first, {}, &std::pair<Id, Eigen::Index>::first);
    for (; place != by_id_.end() && place->first <= range.last; ++place)
      if ((place->first - range.first) % range.step == 0) visit(place->second);
  }
}

// SPC cards of the chosen sets and the permanent constraints PS of the GRID cards, which hold in every case.
void ConstraintBuilder::hold_nodes() {
  sort_numbers();
  if (building_.bulk.with_loads) add_local_nodes();
  std::set<Id> present;
  for (const auto& card : building_.bulk.spcs) present.insert(card.set);
  building_.supports =
      chosen_sets(building_, "SPC", building_.control.spc, building_.control.is_present, present,
                  building_.bulk.spc_sums, building_.bulk.spcs.empty() ? Place{} : building_.bulk.spcs.front().where);
  hold_sets(building_.supports);
}

void ConstraintBuilder::sort_numbers() {
  for (std::size_t i = 0; i < building_.bulk.grids.size(); ++i)
    by_id_.emplace_back(building_.bulk.grids[i].id, static_cast<Eigen::Index>(i));
  std::ranges::sort(by_id_);
}

void ConstraintBuilder::hold_sets(const std::set<Id>& sets) {
  if (by_id_.empty()) sort_numbers();
  for (const auto& card : building_.bulk.spcs)
    if (sets.contains(card.set))
      visit_nodes(
          card, [&](Eigen::Index node) { hold("spc" + std::to_string(card.set), node, card.components, card.where); });
  for (std::size_t i = 0; i < building_.bulk.grids.size(); ++i)
    if (const auto& grid = building_.bulk.grids[i]; grid.held != 0)
      hold("grid_ps", static_cast<Eigen::Index>(i), grid.held, grid.where);
  hold_all();
  for (auto& [name, nodes] : building_.model.mesh.node_sets) {
    std::ranges::sort(nodes);
    nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
  }
}

// sum A_i u_i = 0 with components in the displacement axes of each node. The first term is the dependent one in
// Nastran; here it is preferred as the pivot.
void ConstraintBuilder::add_mpcs() {
  std::set<Id> present;
  for (const auto& card : building_.bulk.mpcs) present.insert(card.set);
  const auto sets =
      chosen_sets(building_, "MPC", building_.control.mpc, building_.control.is_present, present,
                  building_.bulk.mpc_sums, building_.bulk.mpcs.empty() ? Place{} : building_.bulk.mpcs.front().where);
  std::size_t number = 0;
  for (const auto& card : building_.bulk.mpcs) {
    ++number;
    if (!sets.contains(card.set)) continue;
    const auto name = "mpc" + std::to_string(card.set) + "." + std::to_string(number);
    DofSum terms;
    Eigen::Index first = -1;
    bool sound = true;
    for (const auto& term : card.terms) {
      const auto node = building_.node(term.node, "MPC " + std::to_string(card.set), card.where);
      sound = sound && node >= 0;
      if (!sound) break;
      if (first < 0) first = node;
      building_.append(terms, node, term.direction, term.coefficient);
    }
    if (sound) add_equation(name, terms, first, card.terms.front().direction, card.where);
  }
}

std::optional<std::vector<std::pair<Eigen::Index, unsigned>>> ConstraintBuilder::indices(
    const std::vector<std::pair<Id, unsigned>>& nodes, const std::string& title, const Place& where) {
  std::vector<std::pair<Eigen::Index, unsigned>> found;
  bool sound = true;
  for (const auto& [id, components] : nodes) {
    const auto node = building_.node(id, title, where);
    sound = sound && node >= 0;
    found.emplace_back(node, components);
  }
  return sound ? std::optional(found) : std::nullopt;
}

std::array<bool, 6> flags(unsigned components) {
  std::array<bool, 6> directions{};
  for (std::size_t i = 0; i < 6; ++i) directions[i] = ((components >> i) & 1u) != 0;
  return directions;
}

/// The components that do not follow the same master by another card already: pre-processors write one rigid body as
/// several elements that share nodes. Components that follow two masters are a problem.
unsigned ConstraintBuilder::without_shared(const RigidBodyCard& card, Eigen::Index master, Eigen::Index node,
                                           unsigned components) {
  const RigidBodyCard* other = nullptr;
  unsigned fresh = 0;
  for (int i = 0; i < 6; ++i) {
    if (((components >> i) & 1u) == 0) continue;
    const auto [place, is_new] = leads_.try_emplace(NodalDof{node, i}, Lead{master, &card});
    if (is_new)
      fresh |= 1u << i;
    else if (place->second.master != master)
      other = place->second.card;
    else if (place->second.card != &card)
      building_.note(card.where, std::string(card.kind) + "s of one master that share nodes",
                     "these are merged into one rigid body", DeckNoteKind::unused);
  }
  if (other != nullptr)
    building_.files.problem(card.where,
                            "grid point " +
                                std::to_string(building_.model.mesh.node_ids[static_cast<std::size_t>(node)]) +
                                " follows from " + title_of(card) + " and from " + title_of(*other) + " in line " +
                                std::to_string(other->where.line),
                            "a degree of freedom can depend on one element only",
                            "remove it from one of them, or let one master depend on the other");
  return fresh;
}

/// One node leads with all its motions: rigid links, and equations where components are those of turned axes.
void ConstraintBuilder::add_links(const RigidBodyCard& card, Eigen::Index master,
                                  const std::vector<std::pair<Eigen::Index, unsigned>>& dependent) {
  std::map<unsigned, RigidLink> links;
  std::string name = upper_case(card.kind) == "RBE2" ? "rbe2_" : "rigid_";
  name += std::to_string(card.id);
  for (const auto& [node, given] : dependent) {
    if (node == master || given == 0) continue;
    const unsigned components = without_shared(card, master, node, given);
    if (components == 0) continue;
    if (is_simple(node, components)) {
      auto& link = links[components];
      link.where = building_.files.location(card.where);
      link.master = master;
      link.tied = flags(components);
      link.slaves.push_back(node);
    } else {
      for (const auto& [component, terms] : rigid_rows(building_, {{master, all_six}}, {{node, components}}))
        add_equation(name, terms, component.node, component.direction, card.where);
    }
  }
  int part = 0;
  for (auto& [components, link] : links) {
    std::ranges::sort(link.slaves);
    link.slaves.erase(std::ranges::unique(link.slaves).begin(), link.slaves.end());
    link.name = ++part == 1 ? name : name + "." + std::to_string(part);
    building_.model.links.push_back(std::move(link));
  }
}

/// Whether a component that leads also follows. A master that an RBE2 lists among its followers is told and left out.
bool ConstraintBuilder::leads_itself(const RigidBodyCard& card, const NodeComponents& independent,
                                     const NodeComponents& dependent) {
  for (const auto& [leader, leading] : independent)
    for (const auto& [node, following] : dependent) {
      if (node != leader || (leading & following) == 0) continue;
      if (upper_case(card.kind) == "RBE2") {
        building_.note(card.where, "RBE2s that name their master among its followers", "the master leads itself",
                       DeckNoteKind::doubtful);
        continue;
      }
      building_.files.problem(card.where,
                              title_of(card) + ": a component of grid point " +
                                  std::to_string(building_.model.mesh.node_ids[static_cast<std::size_t>(node)]) +
                                  " is independent and dependent",
                              "it either leads or follows", "remove it from one of both lists");
      return true;
    }
  return false;
}

// With all six components of one node independent, the others follow it as rigid links, which stay readable in the
// model. Otherwise the six independent components are spread over nodes, and equations come from R_d R_i^-1: the
// rigid motion from the independent components, then the dependent ones from that.
void ConstraintBuilder::add_rigid_body(const RigidBodyCard& card) {
  const auto title = title_of(card);
  const auto independent = indices(card.independent, title, card.where);
  const auto dependent = indices(card.dependent, title, card.where);
  if (!independent || !dependent) return;
  if (title.starts_with("RROD")) {
    const auto row = rod_row(building_, *dependent);
    if (row)
      add_equation("rigid_" + std::to_string(card.id), row->terms, row->dependent.node, row->dependent.direction,
                   card.where);
    else
      building_.files.problem(card.where, title + " needs two nodes apart and one dependent component",
                              "it keeps the distance between two nodes", "correct GA, GB, CMA and CMB");
    return;
  }
  if (leads_itself(card, *independent, *dependent)) return;
  unsigned leading = 0;
  for (const auto& [node, components] : *independent) leading += static_cast<unsigned>(std::popcount(components));
  for (const auto& [node, components] : *independent)
    if (components == all_six && leading == 6) return add_links(card, node, *dependent);
  const auto rows = rigid_rows(building_, *independent, *dependent);
  if (rows.empty())
    return building_.files.problem(card.where,
                                   title + ": its independent components do not determine a rigid-body motion",
                                   "six independent components must determine it", "choose others");
  for (const auto& [component, terms] : rows)
    add_equation("rigid_" + std::to_string(card.id), terms, component.node, component.direction, card.where);
}

void ConstraintBuilder::add_rigid() {
  for (const auto& card : building_.bulk.rigid) add_rigid_body(card);
}

// RBE3: the reference node takes the weighted mean motion. It stays a weighted link where all components are in
// global axes; turned axes and a UM list, which makes other components dependent, need equations.
void ConstraintBuilder::add_weighted() {
  for (const auto& card : building_.bulk.weighted) {
    const auto title = "RBE3 " + std::to_string(card.id);
    WeightedLink link;
    link.name = "rbe3_" + std::to_string(card.id);
    link.follower = building_.node(card.reference, title, card.where);
    link.tied = flags(card.components);
    link.where = building_.files.location(card.where);
    bool sound = link.follower >= 0, simple = sound && card.moved.empty() && is_simple(link.follower, card.components);
    for (const auto& group : card.groups)
      for (const Id id : group.nodes) {
        const auto node = building_.node(id, title, card.where);
        sound = sound && node >= 0;
        if (!sound || group.weight == 0.0) continue;
        simple = simple && is_simple(node, group.components);
        link.shares.push_back({node, group.weight, flags(group.components)});
      }
    const auto moved = indices(card.moved, title, card.where);
    if (!sound || !moved) continue;
    if (simple) {
      building_.model.weighted_links.push_back(std::move(link));
      continue;
    }
    const auto rows = weighted_rows(building_, link, *moved);
    if (rows.empty())
      building_.files.problem(card.where,
                              title + ": its nodes and components do not determine the motion of the reference node",
                              "or the components of UM are not dependent", "add nodes or components");
    for (const auto& [component, terms] : rows)
      add_equation(link.name, terms, component.node, component.direction, card.where);
  }
}

}  // namespace

std::set<Id> spc_sets(Building& building, std::optional<Id> spc) {
  std::set<Id> sets, present;
  if (!spc) return sets;
  follow_sums(building.bulk.spc_sums, *spc, sets);
  for (const auto& card : building.bulk.spcs) present.insert(card.set);
  if (std::ranges::none_of(sets, [&](Id set) { return present.contains(set); }))
    building.files.problem({}, "SPC = " + std::to_string(*spc) + " of the case control selects a set without cards",
                           "the load case would lack these supports", "add the set or correct the number");
  return sets;
}

std::vector<FixedNodes> supports_of(Building& building, const std::set<Id>& sets) {
  std::vector<FixedNodes> own;
  std::swap(own, building.model.fixed);
  ConstraintBuilder(building).hold_sets(sets);
  std::swap(own, building.model.fixed);
  return own;
}

// Supports first, then what follows (rigid bodies, weighted means), then general equations. Equations are collected and
// reduced together at the end, so that their order does not decide which can be solved.
void build_constraints(Building& building) {
  ConstraintBuilder builder(building);
  builder.hold_nodes();
  builder.add_rigid();
  builder.add_weighted();
  builder.add_mpcs();
  builder.finish();
}

}  // namespace kalfem::nastran
