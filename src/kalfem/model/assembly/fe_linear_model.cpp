#include "kalfem/model/assembly/fe_linear_model.hpp"

#include <charconv>
#include <cmath>
#include <set>

#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {
namespace {

/// The node number in a name such as "n17", nothing in others.
std::optional<std::int64_t> node_number(const std::string& name) {
  std::int64_t number = 0;
  const char* const end = name.data() + name.size();
  if (name.size() < 2 || name.front() != 'n') return {};
  const auto [rest, error] = std::from_chars(name.data() + 1, end, number);
  if (error != std::errc() || rest != end) return {};
  return number;
}

void check(const FiniteElementModel& model, const std::vector<NamedNode>& points, const FeDamping& damping) {
  IssueList issues;
  for (const double factor : {damping.mass_factor, damping.stiffness_factor})
    if (!(factor >= 0.0) || !std::isfinite(factor))
      issues.add({}, "a Rayleigh factor of '" + model.name + "' is " + std::to_string(factor),
                 "it must not be negative: the structure would gain energy");
  std::set<std::string> names;
  for (const auto& [name, node, distance] : points) {
    const std::string title = "point '" + model.name + "." + name + "'";
    if (!names.insert(name).second) issues.add({}, title + " is given twice", "names must be unique");
    if (node < 0 || node >= model.mesh.node_count()) {
      issues.add({}, title + " names the node at position " + std::to_string(node), "it does not exist");
      continue;
    }
    const auto number = node_number(name);
    if (number && *number != model.mesh.node_ids[static_cast<std::size_t>(node)])
      issues.add({}, title + " has the name of another node", "'n' followed by digits refers to a node by its number",
                 "choose another name");
  }
  issues.raise();
}

/// Coefficients of each row of the expansion that belongs to a named node.
std::map<std::string, DofCombination> named_points(const std::vector<NamedNode>& points, const SparseMatrix& expansion,
                                                   const std::vector<std::string>& dofs) {
  const std::set<std::string> own(dofs.begin(), dofs.end());
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = expansion;
  std::map<std::string, DofCombination> combinations;
  for (const auto& [name, node, distance] : points)
    for (int direction = 0; direction < 6; ++direction) {
      const std::string point = name + "." + direction_names[static_cast<std::size_t>(direction)];
      DofCombination combination;
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(rows, 6 * node + direction); it; ++it)
        combination[dofs[static_cast<std::size_t>(it.col())]] = it.value();
      if (!combination.empty() && !own.contains(point)) combinations[point] = std::move(combination);
    }
  return combinations;
}

void add_rayleigh(LinearModel& model, const FeDamping& factors) {
  const auto& [alpha, beta] = factors;
  if (alpha == 0.0 && beta == 0.0) return;
  model.damping += SparseMatrix(alpha * model.mass + beta * model.stiffness);
  if (model.grounds.empty()) return;
  Eigen::MatrixXd pulls(model.size(), static_cast<Eigen::Index>(model.grounds.size()));
  for (std::size_t g = 0; g < model.grounds.size(); ++g)
    pulls.col(static_cast<Eigen::Index>(g)) = model.grounds[g].stiffness;
  // (alpha M + beta K) s with K s = k_g.
  Eigen::MatrixXd drags = beta * pulls;
  if (alpha > 0.0) drags += alpha * (model.mass * semidefinite_solve(model.stiffness, pulls));
  for (std::size_t g = 0; g < model.grounds.size(); ++g)
    model.grounds[g].damping += drags.col(static_cast<Eigen::Index>(g));
}

}  // namespace

LinearModel linear_model(const FiniteElementModel& model, const AssembledModel& assembled,
                         const std::vector<NamedNode>& points, const FeDamping& damping) {
  check(model, points, damping);
  LinearModel linear;
  linear.dofs.reserve(assembled.dofs.size());
  for (const auto& dof : assembled.dofs) linear.dofs.push_back(dof_name(model.mesh, dof));
  linear.mass = evaluate(assembled.mass, assembled.parameters);
  linear.stiffness = evaluate(assembled.stiffness, assembled.parameters);
  linear.damping = assembled.damping;
  linear.grounds = assembled.grounds;
  linear.points = named_points(points, assembled.expansion, linear.dofs);
  add_rayleigh(linear, damping);
  return linear;
}

}  // namespace kalfem
