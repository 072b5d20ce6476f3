// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem {
namespace {

struct Term {
  Eigen::Index dof;
  double coefficient;
};

/// The link or constraint that an equation comes from.
struct Owner {
  const std::string* name;
  const SourceLocation* where;
};

/// "'rbe2_3'", with its line where it is known.
std::string to_string(const Owner& owner) {
  const std::string name = "'" + *owner.name + "'";
  return owner.where->line > 0 ? name + " (line " + std::to_string(owner.where->line) + ")" : name;
}

/// One dependent degree of freedom as a sum of others.
struct Equation {
  Eigen::Index dof;
  Owner owner;
  std::vector<Term> terms;
};

struct Equations {
  std::vector<Equation> list;                        ///< once ordered, each follows only from those before it
  std::unordered_map<Eigen::Index, std::size_t> of;  ///< by dependent degree of freedom
};

std::string name_of(const FiniteElementModel& model, Eigen::Index dof) {
  return dof_name(model.mesh, {dof / 6, static_cast<int>(dof % 6)});
}

/// Sorted by degree of freedom, equal ones added, zeros dropped.
void combine(std::vector<Term>& terms) {
  std::ranges::sort(terms, {}, &Term::dof);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < terms.size();) {
    Term sum = terms[i];
    for (++i; i < terms.size() && terms[i].dof == sum.dof; ++i) sum.coefficient += terms[i].coefficient;
    if (sum.coefficient != 0.0) terms[kept++] = sum;
  }
  terms.resize(kept);
}

/// The same by position among all degrees of freedom.
std::vector<Term> terms_of(const DofSum& sum) {
  std::vector<Term> terms;
  for (const auto& [dof, coefficient] : sum) terms.push_back({all_index(dof), coefficient});
  combine(terms);
  return terms;
}

std::vector<bool> fixed_dofs(const FiniteElementModel& model) {
  std::vector<bool> fixed(static_cast<std::size_t>(6 * model.mesh.node_count()), false);
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (int direction = 0; direction < 6; ++direction)
        if (support.directions[static_cast<std::size_t>(direction)])
          fixed[static_cast<std::size_t>(all_index({node, direction}))] = true;
  return fixed;
}

/// Degrees of freedom that have the same conflict.
struct Conflict {
  const SourceLocation* where;
  Eigen::Index first;
  std::size_t count = 0;

  /// "n3.x follows", or "n3.x and 17 others follow".
  [[nodiscard]] std::string subject(const FiniteElementModel& model, const char* one, const char* many) const {
    if (count == 1) return name_of(model, first) + " " + one;
    return name_of(model, first) + " and " + std::to_string(count - 1) + (count == 2 ? " other " : " others ") + many;
  }
};

/// Collects the equations of links and constraints; doubled dependents are reported once for a pair of owners.
class EquationCollector {
public:
  EquationCollector(const FiniteElementModel& model, IssueList& issues) : model_(model), issues_(issues) {
    for (const auto& link : model.links) add_link(link);
    for (const auto& link : model.weighted_links) add_weighted_link(link);
    for (const auto& constraint : model.constraints) add_constraint(constraint);
    report_doubled();
  }

  Equations take() { return std::move(equations_); }

private:
  void add_link(const RigidLink& link) {
    for (const auto slave : link.slaves) {
      if (slave == link.master) {
        issues_.add({}, "rigid link '" + link.name + "' ties its master n" + id(slave) + " to itself",
                    "a master cannot follow itself", "remove it from the slaves");
        continue;
      }
      const Eigen::Vector3d arm = model_.mesh.nodes.col(slave) - model_.mesh.nodes.col(link.master);
      for (int direction = 0; direction < 6; ++direction)
        if (link.tied[static_cast<std::size_t>(direction)])
          add({all_index({slave, direction}),
               {&link.name, &link.where},
               terms_of(slave_motion(link.master, direction, arm))});
    }
  }

  /// A direction in which the shares leave the follower's motion open is an issue.
  void add_weighted_link(const WeightedLink& link) {
    const MeanMotion mean(model_.mesh, link);
    for (int direction = 0; direction < 6; ++direction) {
      if (!link.tied[static_cast<std::size_t>(direction)]) continue;
      const NodalDof follower{link.follower, direction};
      if (mean.determines(direction))
        add({all_index(follower), {&link.name, &link.where}, terms_of(mean.follower_motion(direction))});
      else
        issues_.add(link.where,
                    "weighted link '" + link.name + "' leaves " + name_of(model_, all_index(follower)) + " open",
                    "the nodes that it follows do not determine this motion",
                    "add nodes off their line, add their rotations, or remove that direction");
    }
  }

  void add_constraint(const MultiPointConstraint& constraint) {
    if (!std::ranges::all_of(constraint.terms, [](const auto& term) { return std::isfinite(term.second); })) {
      issues_.add({}, "constraint '" + constraint.name + "' has a coefficient that is not finite",
                  "a constraint is a weighted sum of displacements with finite coefficients");
      return;
    }
    if (constraint.terms.empty()) {
      issues_.add({}, "constraint '" + constraint.name + "' has no terms", "it constrains nothing");
      return;
    }
    const Eigen::Index dependent = all_index(constraint.terms.front().first);
    auto terms = terms_of(constraint.terms);
    const auto leading = std::ranges::find(terms, dependent, &Term::dof);
    if (leading == terms.end()) {
      issues_.add(
          {},
          "constraint '" + constraint.name + "' has the coefficient 0 at its first term " + name_of(model_, dependent),
          "its first term is expressed by the others", "put a term first whose coefficient is not 0");
      return;
    }
    const double divisor = -leading->coefficient;
    terms.erase(leading);
    for (auto& term : terms) term.coefficient /= divisor;
    add({dependent, {&constraint.name, &constraint.where}, std::move(terms)});
  }

  void add(Equation equation) {
    const auto [place, is_new] = equations_.of.try_emplace(equation.dof, equations_.list.size());
    if (is_new) {
      equations_.list.push_back(std::move(equation));
      return;
    }
    const Owner& first = equations_.list[place->second].owner;
    const Conflict conflict{equation.owner.where, equation.dof};
    ++doubled_.try_emplace({to_string(first), to_string(equation.owner)}, conflict).first->second.count;
  }

  void report_doubled() {
    for (const auto& [owners, conflict] : doubled_)
      issues_.add(
          *conflict.where,
          conflict.subject(model_, "follows", "follow") + " from " + owners.first + " and from " + owners.second,
          "a degree of freedom can depend on one link or constraint only",
          "remove it from one of them, or let one depend on the other");
  }

  std::string id(Eigen::Index node) const {
    return std::to_string(model_.mesh.node_ids[static_cast<std::size_t>(node)]);
  }

  const FiniteElementModel& model_;
  IssueList& issues_;
  Equations equations_;
  std::map<std::pair<std::string, std::string>, Conflict> doubled_;  ///< by both owners
};

void check_fixed(const FiniteElementModel& model, const Equations& equations, const std::vector<bool>& fixed,
                 IssueList& issues) {
  std::map<std::string, Conflict> held;  // by owner
  for (const auto& equation : equations.list)
    if (fixed[static_cast<std::size_t>(equation.dof)])
      ++held.try_emplace(to_string(equation.owner), Conflict{equation.owner.where, equation.dof}).first->second.count;
  for (const auto& [owner, conflict] : held)
    issues.add(*conflict.where,
               conflict.subject(model, "is fixed and follows", "are fixed and follow") + " from " + owner,
               "a fixed degree of freedom cannot depend on another",
               "fix the independent node, or put another term of the constraint first");
}

/// Kahn's order: an equation is taken once all dependent degrees of freedom on its right side have been. What is left
/// over stands in a ring, or hangs on one.
std::vector<std::size_t> substitution_order(const Equations& equations, std::vector<std::size_t>& left_over) {
  const std::size_t n = equations.list.size();
  std::vector<std::size_t> waiting(n, 0), order;
  std::vector<std::vector<std::size_t>> followers(n);
  for (std::size_t i = 0; i < n; ++i)
    for (const auto& term : equations.list[i].terms)
      if (const auto other = equations.of.find(term.dof); other != equations.of.end()) {
        followers[other->second].push_back(i);
        ++waiting[i];
      }
  for (std::size_t i = 0; i < n; ++i)
    if (waiting[i] == 0) order.push_back(i);
  for (std::size_t taken = 0; taken < order.size(); ++taken)
    for (const auto follower : followers[order[taken]])
      if (--waiting[follower] == 0) order.push_back(follower);
  for (std::size_t i = 0; i < n; ++i)
    if (waiting[i] > 0) left_over.push_back(i);
  return order;
}

void report_rings(const FiniteElementModel& model, const Equations& equations,
                  const std::vector<std::size_t>& left_over, IssueList& issues) {
  if (left_over.empty()) return;
  std::set<std::string> owners;
  for (const auto i : left_over) owners.insert(to_string(equations.list[i].owner));
  std::string names;
  for (const auto& owner : owners) names += (names.empty() ? "" : ", ") + owner;
  issues.add({},
             names + ": their degrees of freedom depend on one another in a circle, " +
                 name_of(model, equations.list[left_over.front()].dof) + " among them",
             "a chain of links and constraints must start at an independent degree of freedom",
             "reverse or remove one of them");
}

/// Replaces dependent terms by what they follow from.
void substitute(Equations& equations, const std::vector<std::size_t>& order) {
  for (const auto i : order) {
    std::vector<Term> independent;
    for (const auto& term : equations.list[i].terms) {
      if (const auto other = equations.of.find(term.dof); other != equations.of.end()) {
        for (const auto& inner : equations.list[other->second].terms)
          independent.push_back({inner.dof, term.coefficient * inner.coefficient});
      } else {
        independent.push_back(term);
      }
    }
    combine(independent);
    equations.list[i].terms = std::move(independent);
  }
}

/// Equations whose right sides are independent.
Equations solve(const FiniteElementModel& model, const std::vector<bool>& fixed, IssueList& issues) {
  Equations equations = EquationCollector(model, issues).take();
  check_fixed(model, equations, fixed, issues);
  std::vector<std::size_t> left_over;
  const auto order = substitution_order(equations, left_over);
  report_rings(model, equations, left_over, issues);
  if (issues.empty()) substitute(equations, order);
  return equations;
}

/// Gives wanted degrees of freedom the places of free ones that they follow, see eliminate().
class PivotExchange {
public:
  PivotExchange(const FiniteElementModel& model, const std::vector<bool>& fixed, Equations& equations)
      : fixed_(fixed), equations_(equations) {
    // The size that makes rotations and translations comparable.
    const auto& nodes = model.mesh.nodes;
    if (nodes.cols() > 0) size_ = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
    if (!(size_ > 0.0)) size_ = 1.0;
  }

  void make_independent(const std::vector<NodalDof>& wanted) {
    for (const auto& dof : wanted) wanted_.insert(all_index(dof));
    for (const auto& dof : wanted) exchange(all_index(dof));
  }

private:
  /// Coefficients that are this much smaller than the largest of their sum are its rounding.
  static constexpr double rounding = 1e-13, negligible = 1e-8;

  // Exchanges one dependent degree of freedom with an independent one, a pivot step of Gauss-Jordan elimination:
  // solve its equation for the strongest free term, then substitute that term in all other equations.
  void exchange(Eigen::Index wanted) {
    const auto found = equations_.of.find(wanted);
    if (found == equations_.of.end()) return;
    const std::size_t row = found->second;
    const Term* pivot = strongest(equations_.list[row].terms);
    if (pivot == nullptr) return;
    turn(equations_.list[row], *pivot);
    equations_.of.erase(found);
    equations_.of[equations_.list[row].dof] = row;
    for (std::size_t i = 0; i < equations_.list.size(); ++i)
      if (i != row) replace(equations_.list[i], equations_.list[row]);
  }

  /// What a unit of the term moves, rotations by the size of the model.
  [[nodiscard]] double strength(const Term& term) const {
    return std::abs(term.coefficient) / (term.dof % 6 < 3 ? 1.0 : size_);
  }

  /// The term that moves most among those that are neither held nor wanted; null where only these are left.
  [[nodiscard]] const Term* strongest(const std::vector<Term>& terms) const {
    double all = 0.0;
    const Term* best = nullptr;
    for (const auto& term : terms) {
      all = std::max(all, strength(term));
      if (fixed_[static_cast<std::size_t>(term.dof)] || wanted_.contains(term.dof)) continue;
      if (best == nullptr || strength(term) > strength(*best)) best = &term;
    }
    return best != nullptr && strength(*best) > negligible * all ? best : nullptr;
  }

  /// Solves d = sum c z for the pivot.
  static void turn(Equation& equation, Term pivot) {
    std::erase_if(equation.terms, [&](const Term& term) { return term.dof == pivot.dof; });
    for (auto& term : equation.terms) term.coefficient /= -pivot.coefficient;
    equation.terms.push_back({equation.dof, 1.0 / pivot.coefficient});
    equation.dof = pivot.dof;
    combine(equation.terms);
  }

  static void replace(Equation& equation, const Equation& by) {
    const auto held = std::ranges::lower_bound(equation.terms, by.dof, {}, &Term::dof);
    if (held == equation.terms.end() || held->dof != by.dof) return;
    const double factor = held->coefficient;
    equation.terms.erase(held);
    std::unordered_map<Eigen::Index, double> largest;
    for (const auto& term : equation.terms) largest[term.dof] = std::abs(term.coefficient);
    for (const auto& term : by.terms) {
      const double added = factor * term.coefficient;
      largest[term.dof] = std::max(largest[term.dof], std::abs(added));
      equation.terms.push_back({term.dof, added});
    }
    combine(equation.terms);
    std::erase_if(equation.terms,
                  [&](const Term& term) { return std::abs(term.coefficient) <= rounding * largest[term.dof]; });
  }

  const std::vector<bool>& fixed_;
  Equations& equations_;
  std::set<Eigen::Index> wanted_;
  double size_ = 0.0;  ///< diagonal of the model's box [m]
};

/// Column of every independent degree of freedom in T, -1 for one that is not free.
std::vector<int> number(const Equations& equations, const std::vector<bool>& fixed, const std::vector<bool>& touched,
                        std::vector<NodalDof>& dofs) {
  std::vector<bool> active = touched;
  for (const auto& equation : equations.list)
    if (touched[static_cast<std::size_t>(equation.dof)])
      for (const auto& term : equation.terms) active[static_cast<std::size_t>(term.dof)] = true;
  for (const auto& equation : equations.list) active[static_cast<std::size_t>(equation.dof)] = false;
  std::vector<int> columns(active.size(), -1);
  for (std::size_t i = 0; i < active.size(); ++i)
    if (active[i] && !fixed[i]) {
      columns[i] = static_cast<int>(dofs.size());
      dofs.push_back({static_cast<Eigen::Index>(i / 6), static_cast<int>(i % 6)});
    }
  return columns;
}

}  // namespace

std::vector<Issue> constraint_issues(const FiniteElementModel& model) {
  IssueList issues;
  solve(model, fixed_dofs(model), issues);
  return issues.issues();
}

Elimination eliminate(const FiniteElementModel& model, const std::vector<bool>& touched,
                      const std::vector<NodalDof>& independent) {
  const auto fixed = fixed_dofs(model);
  IssueList issues;
  Equations equations = solve(model, fixed, issues);
  issues.raise();
  if (!independent.empty()) PivotExchange(model, fixed, equations).make_independent(independent);
  Elimination result;
  const auto columns = number(equations, fixed, touched, result.dofs);
  auto& transform = result.transform;
  transform.resize(static_cast<Eigen::Index>(columns.size()), static_cast<Eigen::Index>(result.dofs.size()));
  transform.reserve(transform.cols() + 4 * static_cast<Eigen::Index>(equations.list.size()));
  for (Eigen::Index row = 0; row < transform.rows(); ++row) {
    transform.startVec(row);
    const auto column_of = [&](Eigen::Index dof) { return columns[static_cast<std::size_t>(dof)]; };
    if (const auto equation = equations.of.find(row); equation != equations.of.end()) {
      for (const auto& [dof, coefficient] : equations.list[equation->second].terms)
        if (column_of(dof) >= 0) transform.insertBack(row, column_of(dof)) = coefficient;
    } else if (column_of(row) >= 0) {
      transform.insertBack(row, column_of(row)) = 1.0;
    }
  }
  transform.finalize();
  return result;
}

}  // namespace kalfem
