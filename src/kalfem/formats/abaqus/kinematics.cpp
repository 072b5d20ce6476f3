// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem::abaqus {

/// Whether a node follows the target, through any number of links.
bool Kinematics::leads_to(Index node, Index target) const {
  if (node == target) return true;
  std::vector<Index> waiting = {node};
  std::set<Index> seen;
  while (!waiting.empty()) {
    const Index next = waiting.back();
    waiting.pop_back();
    const auto masters = above_.find(next);
    if (masters == above_.end()) continue;
    for (const Index master : masters->second) {
      if (master == target) return true;
      if (seen.insert(master).second) waiting.push_back(master);
    }
  }
  return false;
}

// A slave's direction follows one master. Where it follows already, or the master would follow its own slave (a ring),
// the tie becomes an equation, which elimination can solve for any of its terms.
void Kinematics::add_link(const std::string& name, Index master, const std::vector<Index>& slaves,
                          const Directions& tied) {
  Link link{name, master, {}};
  for (const Index slave : slaves) {
    if (slave == master) continue;
    const bool ring = leads_to(master, slave);
    Directions follows{};
    for (int d = 0; d < 6; ++d) {
      if (!tied[static_cast<std::size_t>(d)]) continue;
      const NodalDof dof{slave, d};
      if (!ring && leader_.try_emplace(dof, master).second) {
        follows[static_cast<std::size_t>(d)] = true;
        continue;
      }
      // What follows already is tied by an equation.
      DofSum terms = {{dof, -1.0}};
      const auto motion = slave_motion(master, d, model_.mesh.nodes.col(slave) - model_.mesh.nodes.col(master));
      terms.insert(terms.end(), motion.begin(), motion.end());
      add_equation(name, std::move(terms));
    }
    if (follows != Directions{}) {
      link.slaves.emplace_back(slave, follows);
      above_[slave].insert(master);
    }
  }
  if (!link.slaves.empty()) links_.push_back(std::move(link));
}

void Kinematics::add_weighted_link(WeightedLink link, const Where& where) {
  std::erase_if(link.shares, [&](const auto& share) { return share.node == link.follower; });
  if (link.shares.empty()) {
    problems_.add(where, "the coupling '" + link.name + "' has no nodes for its reference node to follow", "",
                  "give its surface at least one node");
    return;
  }
  MeanMotion mean(model_.mesh, link);
  for (int d = 0; d < 6; ++d) {
    bool& tied = link.tied[static_cast<std::size_t>(d)];
    if (!tied || mean.determines(d)) continue;
    notes_.add(problems_.location(where), "coupling '" + link.name + "', direction " + std::to_string(d + 1),
               "its nodes do not determine this motion of the reference node, which is left free",
               DeckNoteKind::changed);
    tied = false;
  }
  means_.insert(link.follower);
  weighted_.push_back({std::move(link), std::move(mean)});
}

void Kinematics::hold(const std::string& name, Index node, int direction) {
  held_.try_emplace(NodalDof{node, direction}, name);
}

// All three directions of a block are the same in any axes, and an axis along a global one is that one. Others are
// equations between the node's global components.
void Kinematics::hold(const std::string& name, Index node, const Eigen::Matrix3d& axes, const Directions& directions) {
  for (int block = 0; block < 6; block += 3) {
    const auto held = [&](int i) { return directions[static_cast<std::size_t>(block + i)]; };
    const bool all = held(0) && held(1) && held(2);
    for (int i = 0; i < 3; ++i) {
      if (!held(i)) continue;
      Index along = 0;
      const double largest = axes.col(i).cwiseAbs().maxCoeff(&along);
      if (all || 1.0 - largest < 1e-12) {
        hold(name, node, block + (all ? i : static_cast<int>(along)));
        continue;
      }
      DofSum terms;
      for (int a = 0; a < 3; ++a) terms.push_back({{node, block + a}, axes(a, i)});
      add_equation(name, std::move(terms));
    }
  }
}

void Kinematics::add_equation(const std::string& name, DofSum terms, std::optional<NodalDof> dependent) {
  equations_.push_back({name, std::move(terms), dependent});
}

/// Follows links up to motions that lead.
void Kinematics::expand(const NodalDof& dof, double factor, std::map<NodalDof, double>& terms, int depth) const {
  const auto leader = leader_.find(dof);
  if (leader == leader_.end() || depth > 1000) {
    terms[dof] += factor;
    return;
  }
  const Eigen::Vector3d arm = model_.mesh.nodes.col(dof.node) - model_.mesh.nodes.col(leader->second);
  for (const auto& [next, share] : slave_motion(leader->second, dof.direction, arm))
    expand(next, factor * share, terms, depth + 1);
}

std::map<NodalDof, double> Kinematics::expanded(const DofSum& given) const {
  std::map<NodalDof, double> terms;
  double largest = 0.0;
  for (const auto& [dof, coefficient] : given) expand(dof, coefficient, terms);
  for (const auto& [dof, coefficient] : terms) largest = std::max(largest, std::abs(coefficient));
  std::erase_if(terms, [&](const auto& term) { return std::abs(term.second) <= 1e-13 * largest; });
  return terms;
}

// Everything is written once it is all known:
//   1. supports of what follows a master become equations, all others hold;
//   2. weighted links whose follower something else acts on become equations;
//   3. the terms of every equation are followed up to motions that lead, held ones dropped;
//   4. the rows are reduced against each other and stored, then links and supports by groups of directions.
void Kinematics::store() {
  for (const auto& [dof, name] : held_)
    if (is_slave(dof))
      add_equation(name, {{dof, 1.0}});
    else
      fixed_.insert(dof);
  ReducedEquations rows(moved_);
  write_weighted_links(rows);
  for (const auto& equation : equations_) {
    DofSum terms;
    for (const auto& [dof, coefficient] : expanded(equation.terms))
      if (!stays_still(dof)) terms.emplace_back(dof, coefficient);
    if (!terms.empty()) rows.add(equation.name, terms, equation.dependent);
  }
  store_links();
  store_fixed();
  rows.store(model_);
}

/// A follower that nothing else acts on stays a weighted link; otherwise its mean motion is written as equations.
void Kinematics::write_weighted_links(ReducedEquations& rows) {
  std::set<NodalDof> used = fixed_;
  for (const auto& equation : equations_)
    for (const auto& [dof, coefficient] : expanded(equation.terms)) used.insert(dof);
  const auto terms_of = [&](const Weighted& weighted, int direction) {
    DofSum terms = weighted.mean.follower_motion(direction);
    terms.insert(terms.begin(), {{weighted.link.follower, direction}, -1.0});
    return terms;
  };
  for (bool changed = true; changed;) {
    changed = false;
    std::set<NodalDof> followers;
    for (auto& weighted : weighted_) {
      if (weighted.as_equations) continue;
      bool taken = false;
      for (int d = 0; d < 6; ++d) {
        const NodalDof dof{weighted.link.follower, d};
        if (weighted.link.tied[static_cast<std::size_t>(d)] && !followers.insert(dof).second) taken = true;
        taken = taken || used.contains(dof) || is_slave(dof);
      }
      if (!taken) continue;
      weighted.as_equations = changed = true;
      for (int d = 0; d < 6; ++d)
        if (weighted.link.tied[static_cast<std::size_t>(d)])
          for (const auto& [dof, coefficient] : expanded(terms_of(weighted, d))) used.insert(dof);
    }
  }
  for (const auto& weighted : weighted_) {
    if (!weighted.as_equations) {
      model_.weighted_links.push_back(weighted.link);
      continue;
    }
    for (int d = 0; d < 6; ++d) {
      if (!weighted.link.tied[static_cast<std::size_t>(d)]) continue;
      DofSum terms;
      for (const auto& [dof, coefficient] : expanded(terms_of(weighted, d)))
        if (!stays_still(dof)) terms.emplace_back(dof, coefficient);
      if (!terms.empty()) rows.add(weighted.link.name, terms, NodalDof{weighted.link.follower, d});
    }
  }
}

void Kinematics::store_links() {
  for (const auto& link : links_) {
    std::map<Directions, std::vector<Index>> groups;
    for (const auto& [slave, follows] : link.slaves) groups[follows].push_back(slave);
    for (auto& [follows, slaves] : groups) model_.links.push_back({link.name, link.master, std::move(slaves), follows});
  }
}

void Kinematics::store_fixed() {
  std::map<NodalDof, std::string> named;
  for (const auto& dof : fixed_) named[dof] = held_.at(dof);
  model_.fixed = grouped_supports(named);
}

std::vector<FixedNodes> grouped_supports(const std::map<NodalDof, std::string>& held) {
  std::vector<FixedNodes> supports;
  std::map<std::string, std::map<Index, Kinematics::Directions>> by_name;
  for (const auto& [dof, name] : held) by_name[name][dof.node][static_cast<std::size_t>(dof.direction)] = true;
  for (const auto& [name, nodes] : by_name) {
    std::map<Kinematics::Directions, std::vector<Index>> groups;
    for (const auto& [node, directions] : nodes) groups[directions].push_back(node);
    for (auto& [directions, members] : groups) supports.push_back({name, std::move(members), directions});
  }
  return supports;
}

}  // namespace kalfem::abaqus
