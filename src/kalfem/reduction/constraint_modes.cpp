#include "kalfem/reduction/constraint_modes.hpp"

namespace kalfem {

using Eigen::Index;
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
