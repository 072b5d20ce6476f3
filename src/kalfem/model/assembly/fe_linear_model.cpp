// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/fe_linear_model.hpp"

#include <algorithm>
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

/// Coefficients of each row of the expansion that belongs to a named node. A node named by its number, "n5", has the
/// names of its degrees of freedom: a reduction keeps it as a point where these go.
std::map<std::string, DofCombination> named_points(const std::vector<NamedNode>& points, const SparseMatrix& expansion,
                                                   const std::vector<std::string>& dofs) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = expansion;
  std::map<std::string, DofCombination> combinations;
  for (const auto& [name, node, distance] : points)
    for (int direction = 0; direction < 6; ++direction) {
      const std::string point = name + "." + direction_names[static_cast<std::size_t>(direction)];
      DofCombination combination;
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(rows, 6 * node + direction); it; ++it)
        combination[dofs[static_cast<std::size_t>(it.col())]] = it.value();
      if (!combination.empty()) combinations[point] = std::move(combination);
    }
  return combinations;
}

// C = alpha M + beta K would also damp the motion that a slow ground carries along without strain. Its shape s solves K
// s = k_g; the ground's rate gets the load (alpha M + beta K) s, which cancels that.
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
  return linear_model(model, assembled, evaluate(assembled.stiffness, assembled.parameters),
                      evaluate(assembled.mass, assembled.parameters), points, damping);
}

LinearModel linear_model(const FiniteElementModel& model, const AssembledModel& assembled, SparseMatrix stiffness,
                         SparseMatrix mass, const std::vector<NamedNode>& points, const FeDamping& damping) {
  check(model, points, damping);
  LinearModel linear;
  linear.dofs.reserve(assembled.dofs.size());
  for (const auto& dof : assembled.dofs) linear.dofs.push_back(dof_name(model.mesh, dof));
  linear.mass = std::move(mass);
  linear.stiffness = std::move(stiffness);
  linear.damping = assembled.viscous_damping(assembled.parameters);
  linear.grounds = assembled.grounds;
  linear.points = named_points(points, assembled.expansion, linear.dofs);
  add_rayleigh(linear, damping);
  return linear;
}

using Eigen::Index;
using FeKind = FiniteElementParameter::Kind;

namespace {

// The matrices are sums of A_i prod_k p_k^n_k, so a derivative lowers one power and multiplies by it: exact.
/// d/dp of a sum of terms; 0 x 0 where p is in none of them.
SparseMatrix derivative_of(const std::vector<AffineTerm>& terms, const std::map<std::string, double>& values,
                           const std::string& parameter) {
  SparseMatrix sum;
  for (const auto& term : terms) {
    const auto power = term.powers.find(parameter);
    if (power == term.powers.end()) continue;
    AffineTerm lowered{term.powers, {}};
    --lowered.powers[parameter];
    add_to(sum, SparseMatrix(power->second * affine_factor(lowered, values) * term.matrix));
  }
  return sum;
}

// Only terms that a parameter changes are projected by themselves. All others together are what is left of the reduced
// matrix, which the reduction gave more exactly than products with T would.
/// T^T A T of the terms that hold one of the parameters, and a last one of what is left of the reduced sum at `values`.
std::vector<AffineTerm> projected(const std::vector<AffineTerm>& terms, const std::map<std::string, double>& values,
                                  const std::set<std::string>& changing, const Eigen::MatrixXd& basis,
                                  const SparseMatrix& reduced_sum) {
  std::vector<AffineTerm> small;
  SparseMatrix constant = reduced_sum;
  for (const auto& term : terms) {
    if (std::ranges::none_of(term.powers, [&](const auto& power) { return changing.contains(power.first); })) continue;
    const Eigen::MatrixXd product = basis.transpose() * (term.matrix * basis);
    small.push_back({term.powers, Eigen::MatrixXd(0.5 * (product + product.transpose())).sparseView()});
    constant = SparseMatrix(constant - affine_factor(term, values) * small.back().matrix);
  }
  small.push_back({{}, constant});
  return small;
}

void apply(FiniteElementDamping& damping, const FiniteElementParameter& parameter, double value) {
  if (parameter.kind == FeKind::mass_factor) damping.rayleigh.mass_factor = value;
  if (parameter.kind == FeKind::stiffness_factor) damping.rayleigh.stiffness_factor = value;
  if (parameter.kind == FeKind::modal_ratio) damping.modal_ratios.values[parameter.ratio] = value;
  if (parameter.kind == FeKind::all_modal_ratios) std::ranges::fill(damping.modal_ratios.values, value);
}

bool ends_with_any(const std::string& name, const std::vector<std::string>& ends) {
  return std::ranges::any_of(ends, [&](const auto& end) { return name.ends_with(end); });
}

}  // namespace

std::vector<std::pair<std::string, FiniteElementParameter>> parameters_of(const AssembledModel& assembled,
                                                                          const FiniteElementDamping& damping) {
  std::vector<std::pair<std::string, FiniteElementParameter>> all;
  for (const auto& [name, value] : assembled.parameters) all.push_back({name, {FeKind::matrix, name, 0}});
  if (!damping.modal_ratios.empty()) all.push_back({"damping.modal", {FeKind::all_modal_ratios, "", 0}});
  for (std::size_t i = 0; i < damping.modal_ratios.values.size(); ++i)
    all.push_back({"damping.modal." + std::to_string(i + 1), {FeKind::modal_ratio, "", i}});
  all.push_back({"damping.mass_factor", {FeKind::mass_factor, "", 0}});
  all.push_back({"damping.stiffness_factor", {FeKind::stiffness_factor, "", 0}});
  return all;
}

std::string unit_of(const FiniteElementParameter& parameter) {
  if (parameter.kind == FeKind::mass_factor) return "1/s";
  if (parameter.kind == FeKind::stiffness_factor) return "s";
  if (parameter.kind != FeKind::matrix) return "-";
  if (parameter.name.ends_with(".youngs_modulus")) return "Pa";
  if (parameter.name.ends_with(".density")) return "kg/m^3";
  if (parameter.name.ends_with(".thickness")) return "m";
  if (parameter.name.ends_with(".mass")) return "kg";
  if (ends_with_any(parameter.name, {".offset_x", ".offset_y", ".offset_z"})) return "m";
  if (ends_with_any(parameter.name, {".factor", ".axial", ".bending", ".bending_y", ".bending_z", ".torsion"}))
    return "-";
  return "";  // a spring's stiffness: [N/m] or [N m/rad]
}

double value_of(const AssembledModel& assembled, const FiniteElementDamping& damping,
                const FiniteElementParameter& parameter) {
  if (parameter.kind == FeKind::mass_factor) return damping.rayleigh.mass_factor;
  if (parameter.kind == FeKind::stiffness_factor) return damping.rayleigh.stiffness_factor;
  if (parameter.kind != FeKind::matrix) return damping.modal_ratios.values[parameter.ratio];
  return assembled.parameters.at(parameter.name);
}

ParameterisedFiniteElements::ParameterisedFiniteElements(std::shared_ptr<const AssembledModel> assembled,
                                                         std::shared_ptr<const LinearModel> full,
                                                         FiniteElementDamping damping,
                                                         std::vector<ParameterBinding<FiniteElementParameter>> bindings,
                                                         Index count)
    : assembled_(std::move(assembled)),
      full_(std::move(full)),
      damping_(std::move(damping)),
      bindings_(std::move(bindings)),
      count_(count) {
  if (assembled_->stiffness.empty() && !bindings_.empty())
    throw InvalidInput("a parameter shall change matrices that were summed at its present value",
                       "the terms that it is a factor of are gone",
                       "assemble without AssemblyOptions::at_present_values");
}

std::map<std::string, double> ParameterisedFiniteElements::values_at(const Eigen::VectorXd& parameters) const {
  auto values = assembled_->parameters;
  for (const auto& [index, target] : bindings_)
    if (target.kind == FeKind::matrix) values[target.name] = parameters[index];
  return values;
}

FiniteElementDamping ParameterisedFiniteElements::damping_at(const Eigen::VectorXd& parameters) const {
  FiniteElementDamping damping = damping_;
  for (const auto& [index, target] : bindings_) apply(damping, target, parameters[index]);
  return damping;
}

ModelAtParameters ParameterisedFiniteElements::at(const Eigen::VectorXd& parameters) const {
  const auto values = values_at(parameters);
  const FiniteElementDamping damping = damping_at(parameters);
  LinearModel model;
  model.dofs = full_->dofs;
  const bool constant =
      std::ranges::none_of(bindings_, [](const auto& each) { return each.target.kind == FeKind::matrix; });
  model.mass = constant ? full_->mass : evaluate(assembled_->mass, values);
  model.stiffness = constant ? full_->stiffness : evaluate(assembled_->stiffness, values);
  model.damping = assembled_->viscous_damping(values);
  const auto& [alpha, beta] = damping.rayleigh;
  if (alpha != 0.0 || beta != 0.0) model.damping += SparseMatrix(alpha * model.mass + beta * model.stiffness);
  model.grounds = full_->grounds;
  model.points = full_->points;
  model.gauges = full_->gauges;
  model.points_only = full_->points_only;
  model.coordinate_scale = full_->coordinate_scale;
  return {std::move(model), damping.modal_ratios};
}

std::vector<ModelDerivative> ParameterisedFiniteElements::derivatives(const Eigen::VectorXd& parameters) const {
  const auto values = values_at(parameters);
  const FiniteElementDamping damping = damping_at(parameters);
  const auto& [alpha, beta] = damping.rayleigh;
  std::vector<ModelDerivative> all(static_cast<std::size_t>(count_));
  for (const auto& [index, target] : bindings_) {
    auto& derivative = all[static_cast<std::size_t>(index)];
    if (target.kind == FeKind::matrix) {
      const SparseMatrix stiffness = derivative_of(assembled_->stiffness, values, target.name),
                         mass = derivative_of(assembled_->mass, values, target.name),
                         viscous = derivative_of(assembled_->factored_damping, values, target.name);
      add_to(derivative.stiffness, stiffness);
      add_to(derivative.mass, mass);
      if (viscous.size() > 0) add_to(derivative.damping, viscous);
      if (alpha != 0.0) add_to(derivative.damping, SparseMatrix(alpha * mass));
      if (beta != 0.0) add_to(derivative.damping, SparseMatrix(beta * stiffness));
    } else if (target.kind == FeKind::mass_factor) {
      add_to(derivative.damping, evaluate(assembled_->mass, values));
    } else if (target.kind == FeKind::stiffness_factor) {
      add_to(derivative.damping, evaluate(assembled_->stiffness, values));
    } else {
      derivative.modal_ratios.resize(damping.modal_ratios.values.size(), 0.0);
      for (std::size_t i = 0; i < damping.modal_ratios.values.size(); ++i)
        if (target.kind == FeKind::all_modal_ratios || i == target.ratio) derivative.modal_ratios[i] = 1.0;
    }
  }
  return all;
}

// The basis stays that of the values given, so the reduced matrices remain affine in the same products of parameters
// and their derivatives exact for the reduced model. How far from those values the basis serves is the reduction's
// question.
ParameterisedFiniteElements ParameterisedFiniteElements::in_basis(const Eigen::MatrixXd& basis,
                                                                  const LinearModel& reduced,
                                                                  const Eigen::VectorXd& parameters) const {
  std::set<std::string> changing;
  for (const auto& [index, target] : bindings_)
    if (target.kind == FeKind::matrix) changing.insert(target.name);
  AssembledModel small;
  small.parameters = values_at(parameters);
  small.stiffness = projected(assembled_->stiffness, small.parameters, changing, basis, reduced.stiffness);
  small.mass = projected(assembled_->mass, small.parameters, changing, basis, reduced.mass);
  const FiniteElementDamping damping = damping_at(parameters);
  const auto& [alpha, beta] = damping.rayleigh;
  small.factored_damping = projected(assembled_->factored_damping, small.parameters, changing, basis,
                                     SparseMatrix(reduced.damping - alpha * reduced.mass - beta * reduced.stiffness));
  small.damping = std::move(small.factored_damping.back().matrix);  // what no parameter changes
  small.factored_damping.pop_back();
  return {std::make_shared<const AssembledModel>(std::move(small)), std::make_shared<const LinearModel>(reduced),
          damping, bindings_, count_};
}

}  // namespace kalfem
