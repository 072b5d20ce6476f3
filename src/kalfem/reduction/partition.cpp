#include "kalfem/reduction/partition.hpp"

#include <unordered_map>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/sparse_operations.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr Index outside = -1;

std::vector<Index> indices_of(const LinearModel& model, const std::vector<std::string>& boundary) {
  std::unordered_map<std::string, Index> known;
  for (Index i = 0; i < model.size(); ++i) known.emplace(model.dofs[static_cast<std::size_t>(i)], i);
  IssueList issues;
  std::vector<Index> indices;
  for (const auto& name : boundary) {
    const auto found = known.find(name);
    if (found == known.end())
      issues.add({}, "the model has no degree of freedom '" + name + "'" + did_you_mean(name, model.dofs),
                 "the boundary must consist of degrees of freedom of the model", "name one of them");
    else if (found->second == outside)
      issues.add({}, "the boundary names '" + name + "' twice", "each degree of freedom can be kept only once",
                 "name it once");
    else
      indices.push_back(std::exchange(found->second, outside));
  }
  issues.raise();
  return indices;
}

}  // namespace

Partition partition(const LinearModel& model, const std::vector<std::string>& boundary) {
  Partition parts;
  parts.boundary = indices_of(model, boundary);
  std::vector<bool> kept(model.dofs.size(), false);
  for (const Index i : parts.boundary) kept[static_cast<std::size_t>(i)] = true;
  for (Index i = 0; i < model.size(); ++i) {
    if (kept[static_cast<std::size_t>(i)]) continue;
    parts.interior.push_back(i);
    parts.interior_names.push_back(model.dofs[static_cast<std::size_t>(i)]);
  }
  parts.stiffness_ii = select(model.stiffness, parts.interior, parts.interior);
  parts.mass_ii = select(model.mass, parts.interior, parts.interior);
  parts.stiffness_ib = select(model.stiffness, parts.interior, parts.boundary);
  return parts;
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Degrees of freedom that hold the rigid-body modes best: those of the pivots of R^T, each row of R by the stiffness
/// there, so that rotations and translations compare.
std::vector<Index> supports(const SparseMatrix& stiffness, const MatrixXd& rigid_modes) {
  if (rigid_modes.cols() == 0) return {};
  const VectorXd scale = stiffness.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::ColPivHouseholderQR<MatrixXd> pivots(MatrixXd(rigid_modes.transpose() * scale.asDiagonal()));
  const auto order = pivots.colsPermutation().indices().head(rigid_modes.cols());
  return {order.begin(), order.end()};
}

/// The loads on a free body that its displacements answer are in equilibrium, so springs at a statically determinate
/// support carry nothing, whatever their stiffness: the solution is that of the free body.
MatrixXd solve_supported(const Partition& parts, const MatrixXd& loads, const MatrixXd& rigid_modes) {
  SparseMatrix supported = parts.stiffness_ii;
  for (const Index dof : supports(parts.stiffness_ii, rigid_modes)) supported.coeffRef(dof, dof) *= 2.0;
  const SparseFactor factor(supported);
  MatrixXd displacements = factor.solve(loads);
  // What the factor of a nearly singular matrix lost in the first place.
  displacements += factor.solve(loads - parts.stiffness_ii * displacements);
  return displacements - rigid_modes * (rigid_modes.transpose() * (parts.mass_ii * displacements));
}

}  // namespace

MatrixXd interior_response(const Partition& parts, const ShiftedStiffness& factored, const MatrixXd& loads,
                           const MatrixXd& rigid_modes) {
  return factored.shift == 0.0 ? factored.factor.solve(loads) : solve_supported(parts, loads, rigid_modes);
}

MatrixXd constraint_modes(const Partition& parts, const ShiftedStiffness& factored, const MatrixXd& rigid_modes) {
  return interior_response(parts, factored, -MatrixXd(parts.stiffness_ib), rigid_modes);
}

double static_error(const Partition& parts, const MatrixXd& modes) {
  if (modes.size() == 0) return 0.0;
  const MatrixXd unbalanced = parts.stiffness_ii * modes + parts.stiffness_ib;
  double largest = 0.0;
  for (Index j = 0; j < modes.cols(); ++j)
    if (const double load = parts.stiffness_ib.col(j).norm(); load > 0.0)
      largest = std::max(largest, unbalanced.col(j).norm() / load);
  return largest;
}

}  // namespace kalfem
