#include "kalfem/model/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

namespace kalfem {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Term {
  Eigen::Index dof;
  double coefficient;
};

/// One dependent degree of freedom as a sum of others.
struct Equation {
  Eigen::Index dof;
  const std::string* owner;  ///< name of its link or constraint
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

std::vector<bool> fixed_dofs(const FiniteElementModel& model) {
  std::vector<bool> fixed(static_cast<std::size_t>(6 * model.mesh.node_count()), false);
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (int direction = 0; direction < 6; ++direction)
        if (support.directions[static_cast<std::size_t>(direction)])
          fixed[static_cast<std::size_t>(all_index({node, direction}))] = true;
  return fixed;
}

/// Collects the equations of links and constraints; a doubled dependent is reported once a node and pair of owners.
class EquationCollector {
public:
  EquationCollector(const FiniteElementModel& model, IssueList& issues) : model_(model), issues_(issues) {
    for (const auto& link : model.links) add_link(link);
    for (const auto& link : model.weighted_links) add_weighted_link(link);
    for (const auto& constraint : model.constraints) add_constraint(constraint);
  }

  Equations take() { return std::move(equations_); }

private:
  void add_link(const RigidLink& link) {
    for (const auto slave : link.slaves) {
      if (slave == link.master) {
        issues_.add({}, "rigid link '" + link.name + "' ties its master n" + id(slave) + " to itself",
                    "the master leads and does not follow", "leave it out of the slaves");
        continue;
      }
      const Eigen::Vector3d arm = model_.mesh.nodes.col(slave) - model_.mesh.nodes.col(link.master);
      for (int direction = 0; direction < 6; ++direction)
        if (link.tied[static_cast<std::size_t>(direction)])
          add({all_index({slave, direction}), &link.name, rigid_motion(link.master, direction, arm)});
    }
  }

  /// Row `direction` of u_s = u_m + theta_m x arm, theta_s = theta_m.
  static std::vector<Term> rigid_motion(Eigen::Index master, int direction, const Eigen::Vector3d& arm) {
    std::vector<Term> terms = {{all_index({master, direction}), 1.0}};
    if (direction < 3) {
      const int next = (direction + 1) % 3, last = (direction + 2) % 3;
      terms.push_back({all_index({master, 3 + next}), arm[last]});
      terms.push_back({all_index({master, 3 + last}), -arm[next]});
    }
    combine(terms);
    return terms;
  }

  /// q = (sum S_i^T W_i S_i)^+ sum S_i^T W_i z_i; a direction in which the shares leave the motion open is an issue.
  void add_weighted_link(const WeightedLink& link) {
    const auto& nodes = model_.mesh.nodes;
    double distance = 0.0;
    for (const auto& share : link.shares) distance += (nodes.col(share.node) - nodes.col(link.follower)).norm();
    distance = distance > 0.0 ? distance / static_cast<double>(link.shares.size()) : 1.0;
    // Rotations times the distance make all entries of one unit.
    const Vector6 scale = (Vector6() << 1, 1, 1, 1 / distance, 1 / distance, 1 / distance).finished();
    Matrix6 normal = Matrix6::Zero();
    Eigen::MatrixXd fit(6, 6 * static_cast<Eigen::Index>(link.shares.size()));
    for (std::size_t i = 0; i < link.shares.size(); ++i) {
      const auto& share = link.shares[i];
      const Eigen::Vector3d arm = nodes.col(share.node) - nodes.col(link.follower);
      Matrix6 rigid = Matrix6::Identity();
      rigid.topRightCorner<3, 3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
      Vector6 weights = Vector6::Zero();
      for (int d = 0; d < 6; ++d)
        if (share.directions[static_cast<std::size_t>(d)])
          weights[d] = share.weight * (d < 3 ? 1.0 : distance * distance);
      const Matrix6 weighted = scale.asDiagonal() * rigid.transpose() * weights.asDiagonal();
      normal += weighted * rigid * scale.asDiagonal();
      fit.middleCols<6>(6 * static_cast<Eigen::Index>(i)) = weighted;
    }
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(6, 6);
    solver.setThreshold(1e-9);
    solver.compute(normal);
    const Eigen::MatrixXd determined = solver.solve(Eigen::MatrixXd(normal));
    const Eigen::MatrixXd motion = scale.asDiagonal() * solver.solve(fit);
    for (int direction = 0; direction < 6; ++direction) {
      if (!link.tied[static_cast<std::size_t>(direction)]) continue;
      if (std::abs(determined(direction, direction) - 1.0) > 1e-6) {
        issues_.add({},
                    "weighted link '" + link.name + "' leaves " +
                        name_of(model_, all_index({link.follower, direction})) + " open",
                    "the nodes that it follows do not determine that motion",
                    "add nodes off their line, or their rotations, or leave that direction out");
        continue;
      }
      std::vector<Term> terms;
      for (Eigen::Index column = 0; column < motion.cols(); ++column)
        if (const double coefficient = motion(direction, column);
            std::abs(coefficient) > 1e-14 * std::max(1.0, 1.0 / distance))
          terms.push_back(
              {all_index({link.shares[static_cast<std::size_t>(column / 6)].node, static_cast<int>(column % 6)}),
               coefficient});
      combine(terms);
      add({all_index({link.follower, direction}), &link.name, std::move(terms)});
    }
  }

  void add_constraint(const MultiPointConstraint& constraint) {
    std::vector<Term> terms;
    bool finite = true;
    for (const auto& [dof, coefficient] : constraint.terms) {
      terms.push_back({all_index(dof), coefficient});
      finite = finite && std::isfinite(coefficient);
    }
    if (!finite) {
      issues_.add({}, "constraint '" + constraint.name + "' has a coefficient that is not finite",
                  "it is a weighted sum of displacements");
      return;
    }
    if (terms.empty()) {
      issues_.add({}, "constraint '" + constraint.name + "' has no terms", "it constrains nothing");
      return;
    }
    const Eigen::Index dependent = terms.front().dof;
    combine(terms);
    const auto leading = std::ranges::find(terms, dependent, &Term::dof);
    if (leading == terms.end()) {
      issues_.add(
          {},
          "constraint '" + constraint.name + "' has the coefficient 0 at its first term " + name_of(model_, dependent),
          "its first term follows from the others", "begin with a term that is not 0");
      return;
    }
    const double divisor = -leading->coefficient;
    terms.erase(leading);
    for (auto& term : terms) term.coefficient /= divisor;
    add({dependent, &constraint.name, std::move(terms)});
  }

  void add(Equation equation) {
    const auto [place, is_new] = equations_.of.try_emplace(equation.dof, equations_.list.size());
    if (is_new) {
      equations_.list.push_back(std::move(equation));
      return;
    }
    const std::string& first = *equations_.list[place->second].owner;
    if (doubled_.insert({equation.dof / 6, first, *equation.owner}).second)
      issues_.add({},
                  name_of(model_, equation.dof) + " follows from '" + first + "' and from '" + *equation.owner + "'",
                  "a degree of freedom can follow from one link or constraint",
                  "leave it out of one of them, or let one follow the other");
  }

  std::string id(Eigen::Index node) const {
    return std::to_string(model_.mesh.node_ids[static_cast<std::size_t>(node)]);
  }

  const FiniteElementModel& model_;
  IssueList& issues_;
  Equations equations_;
  std::set<std::tuple<Eigen::Index, std::string, std::string>> doubled_;
};

void check_fixed(const FiniteElementModel& model, const Equations& equations, const std::vector<bool>& fixed,
                 IssueList& issues) {
  std::set<std::pair<Eigen::Index, std::string>> seen;
  for (const auto& equation : equations.list)
    if (fixed[static_cast<std::size_t>(equation.dof)] && seen.insert({equation.dof / 6, *equation.owner}).second)
      issues.add({}, name_of(model, equation.dof) + " is fixed and follows from '" + *equation.owner + "'",
                 "what is fixed cannot follow another",
                 "fix the node that leads, or let another term of the constraint come first");
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
  for (const auto i : left_over) owners.insert("'" + *equations.list[i].owner + "'");
  std::string names;
  for (const auto& owner : owners) names += (names.empty() ? "" : ", ") + owner;
  issues.add({},
             names + ": their degrees of freedom follow from one another in a ring, " +
                 name_of(model, equations.list[left_over.front()].dof) + " among them",
             "a chain of links and constraints must begin at an independent degree of freedom",
             "turn one of them round, or leave it out");
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

Elimination eliminate(const FiniteElementModel& model, const std::vector<bool>& touched) {
  const auto fixed = fixed_dofs(model);
  IssueList issues;
  const Equations equations = solve(model, fixed, issues);
  issues.raise();
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
