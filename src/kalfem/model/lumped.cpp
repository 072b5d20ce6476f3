// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/lumped.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace kalfem {
namespace {

bool is_ground(const LumpedSubstructure& substructure, const std::string& point) {
  return std::ranges::find(substructure.grounds, point) != substructure.grounds.end();
}

bool is_dof(const LumpedSubstructure& substructure, const std::string& name) {
  return std::ranges::find(substructure.matrices.dofs, name) != substructure.matrices.dofs.end() ||
         std::ranges::find(substructure.masses, name, &LumpedMass::dof) != substructure.masses.end();
}

std::vector<std::string> point_names(const LumpedSubstructure& substructure) {
  std::vector<std::string> names = substructure.grounds;
  for (const auto& dof : dofs_of(substructure)) names.push_back(dof);
  for (const auto& [name, combination] : substructure.points) names.push_back(name);
  return names;
}

/// Displacement of a point per degree of freedom; zero for a ground.
Eigen::VectorXd participation(const LumpedSubstructure& substructure, const std::string& point) {
  const auto dofs = dofs_of(substructure);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(std::ssize(dofs));
  for (std::size_t i = 0; i < dofs.size(); ++i)
    if (dofs[i] == point) vector[static_cast<Eigen::Index>(i)] = 1.0;
  if (const auto named = substructure.points.find(point); named != substructure.points.end())
    for (const auto& [dof, coefficient] : named->second) vector += coefficient * participation(substructure, dof);
  return vector;
}

void check_masses(const LumpedSubstructure& substructure, IssueList& issues) {
  std::set<std::string> seen;
  for (const auto& dof : dofs_of(substructure))
    if (!seen.insert(dof).second)
      issues.add({}, "mass '" + substructure.name + "." + dof + "' is given twice", "names must be unique");
  for (const auto& [dof, mass] : substructure.masses) {
    if (!(mass > 0.0) || !std::isfinite(mass))
      issues.add({}, "mass of '" + substructure.name + "." + dof + "' is " + std::to_string(mass),
                 "a mass must be positive and finite", "give the mass in kg");
  }
}

void check_springs(const LumpedSubstructure& substructure, IssueList& issues) {
  const auto known = point_names(substructure);
  for (const auto& spring : substructure.springs) {
    const std::string title = "spring '" + substructure.name + "." + spring.name + "'";
    for (const auto& end : {spring.from, spring.to})
      if (std::ranges::find(known, end) == known.end())
        issues.add({}, title + " ends at '" + end + "', which does not exist" + did_you_mean(end, known),
                   "a spring connects masses, points or grounds of its substructure");
    if (spring.from == spring.to) issues.add({}, title + " joins '" + spring.from + "' to itself", "it has no effect");
    for (const double value : {spring.stiffness, spring.damping})
      if (!(value >= 0.0) || !std::isfinite(value))
        issues.add({}, title + " has the value " + std::to_string(value),
                   "stiffness and damping of a lumped spring must not be negative");
  }
}

/// A name that is a mass, a ground and a point at once would be taken for one of them silently.
void check_names(const LumpedSubstructure& substructure, IssueList& issues) {
  const auto is_mass = [&](const std::string& name) { return is_dof(substructure, name); };
  std::set<std::string> grounds;
  for (const auto& ground : substructure.grounds)
    if (!grounds.insert(ground).second || is_mass(ground))
      issues.add({}, "ground '" + substructure.name + "." + ground + "' has the name of a mass or another ground",
                 "names must be unique");
  for (const auto& [name, combination] : substructure.points)
    if (is_mass(name) || grounds.contains(name))
      issues.add({}, "point '" + substructure.name + "." + name + "' has the name of a mass or a ground",
                 "names must be unique");
}

void check_points(const LumpedSubstructure& substructure, IssueList& issues) {
  for (const auto& [name, combination] : substructure.points)
    for (const auto& [dof, coefficient] : combination) {
      if (!std::isfinite(coefficient))
        issues.add(
            {}, "point '" + substructure.name + "." + name + "' has a coefficient of '" + dof + "' that is not finite",
            "a point is a weighted sum of degrees of freedom");
      if (!is_dof(substructure, dof))
        issues.add(
            {}, "point '" + substructure.name + "." + name + "' uses '" + dof + "', which is not a degree of freedom",
            "a point is a weighted sum of degrees of freedom");
    }
}

/// Up to rounding of its largest entry.
bool is_symmetric(const SparseMatrix& matrix) {
  const SparseMatrix difference = matrix - SparseMatrix(matrix.transpose());
  return difference.coeffs().size() == 0 ||
         difference.coeffs().abs().maxCoeff() <= 1e-9 * matrix.coeffs().abs().maxCoeff();
}

void check_matrices(const LumpedSubstructure& substructure, IssueList& issues) {
  const auto& [dofs, mass, damping, stiffness] = substructure.matrices;
  for (const auto& [letter, matrix] : {std::pair{"M", &mass}, std::pair{"C", &damping}, std::pair{"K", &stiffness}}) {
    const std::string title = std::string(letter) + " of '" + substructure.name + "'";
    const bool fits = matrix->rows() == std::ssize(dofs) && matrix->cols() == std::ssize(dofs);
    if (matrix->size() == 0) continue;
    if (!fits)
      issues.add({},
                 title + " is " + std::to_string(matrix->rows()) + " x " + std::to_string(matrix->cols()) + ", with " +
                     std::to_string(dofs.size()) + " names",
                 "it has a row and a column for each degree of freedom", "give as many names as rows");
    else if (!matrix->coeffs().allFinite())
      issues.add({}, title + " has entries that are not finite", "it belongs to the equation of motion", "");
    else if (!is_symmetric(*matrix))
      issues.add({}, title + " is not symmetric", "mass, damping and stiffness have both triangles alike",
                 "give (A + A^T) / 2 if the difference is rounding");
  }
  if (mass.size() == 0 && !dofs.empty())
    issues.add({}, "M of '" + substructure.name + "' is missing", "its degrees of freedom need masses", "give M");
}

void check_damping(const LumpedSubstructure& substructure, IssueList& issues) {
  for (const double ratio : substructure.modal_damping)
    if (!(ratio >= 0.0 && ratio < 1.0))
      issues.add({}, "modal damping ratio of '" + substructure.name + "' is " + std::to_string(ratio),
                 "a ratio must lie in [0, 1)", "write 1 % or 0.01");
  const auto& [alpha, beta] = substructure.rayleigh;
  if (!(alpha >= 0.0 && beta >= 0.0) || !std::isfinite(alpha + beta))
    issues.add({}, "Rayleigh factors of '" + substructure.name + "' are negative or not finite",
               "they must not be: the structure would gain energy");
}

/// Adds a given matrix to its place before the masses; one that is empty counts as 0.
void add_block(const SparseMatrix& given, Eigen::MatrixXd& matrix) {
  if (given.size() > 0) matrix.topLeftCorner(given.rows(), given.cols()) += given;
}

GroundCoupling& coupling_of(LinearModel& model, const std::string& ground) {
  for (auto& coupling : model.grounds)
    if (coupling.ground == ground) return coupling;
  const auto zero = Eigen::VectorXd::Zero(model.size());
  return model.grounds.emplace_back(GroundCoupling{ground, zero, zero});
}

/// Damping that is not a dashpot: modal and Rayleigh.
Eigen::MatrixXd material_damping(const LumpedSubstructure& substructure, const LinearModel& model) {
  const auto& [alpha, beta] = substructure.rayleigh;
  Eigen::MatrixXd damping = alpha * model.mass + beta * model.stiffness;
  if (!substructure.modal_damping.empty() && model.size() > 0)
    damping += modal_damping(model.mass, normal_modes(model.mass, model.stiffness), substructure.modal_damping);
  return damping;
}

/// Shape in which the model follows a slowly moving ground, K s = k_g: material damping acts on the motion relative to
/// it.
Eigen::VectorXd pseudo_static_shape(const Eigen::MatrixXd& stiffness, const Eigen::VectorXd& ground_stiffness) {
  if (stiffness.size() == 0) return ground_stiffness;
  return stiffness.completeOrthogonalDecomposition().solve(ground_stiffness);
}

}  // namespace

std::vector<std::string> dofs_of(const LumpedSubstructure& substructure) {
  std::vector<std::string> dofs = substructure.matrices.dofs;
  for (const auto& mass : substructure.masses) dofs.push_back(mass.dof);
  return dofs;
}

std::vector<Issue> validate(const LumpedSubstructure& substructure) {
  IssueList issues;
  check_matrices(substructure, issues);
  check_masses(substructure, issues);
  check_springs(substructure, issues);
  check_names(substructure, issues);
  check_points(substructure, issues);
  check_damping(substructure, issues);
  return issues.issues();
}

// With b the elongation of a spring per degree of freedom, it adds k b b^T to K and c b b^T to C, and a moving ground
// at its end pulls with k and c times its motion. Modal and Rayleigh damping come last, as they need the whole K and M;
// a slow motion of a ground must not be damped by them, so its rate gets the damping of the shape that it carries
// along.
LinearModel assemble(const LumpedSubstructure& substructure) {
  if (auto issues = validate(substructure); !issues.empty()) throw InvalidInput(std::move(issues));
  LinearModel model;
  model.points = substructure.points;
  model.dofs = dofs_of(substructure);
  const Eigen::Index n = model.size(), given = std::ssize(substructure.matrices.dofs);
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(n, n), damping = mass, stiffness = mass;
  for (Eigen::Index i = given; const auto& [dof, value] : substructure.masses) mass(i, i) = value, ++i;
  add_block(substructure.matrices.mass, mass);
  add_block(substructure.matrices.damping, damping);
  add_block(substructure.matrices.stiffness, stiffness);
  for (const auto& ground : substructure.grounds) coupling_of(model, ground);
  for (const auto& spring : substructure.springs) {
    const Eigen::VectorXd elongation =
        participation(substructure, spring.to) - participation(substructure, spring.from);
    stiffness += spring.stiffness * elongation * elongation.transpose();
    damping += spring.damping * elongation * elongation.transpose();
    // The ground's motion pulls its end: f = -b (b^T z + s r) with s = +1 at `to`, -1 at `from`.
    for (const auto& [end, sign] : {std::pair{spring.to, 1.0}, std::pair{spring.from, -1.0}}) {
      if (!is_ground(substructure, end)) continue;
      coupling_of(model, end).stiffness -= sign * spring.stiffness * elongation;
      coupling_of(model, end).damping -= sign * spring.damping * elongation;
    }
  }
  model.mass = mass.sparseView();
  model.stiffness = stiffness.sparseView();
  const Eigen::MatrixXd material = material_damping(substructure, model);
  for (auto& ground : model.grounds) ground.damping += material * pseudo_static_shape(stiffness, ground.stiffness);
  model.damping = (damping + material).sparseView();
  return model;
}

}  // namespace kalfem
