#include "kalfem/model/checks/grounding_check.hpp"

#include <algorithm>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double strain_rounding = 1e-10;  ///< of a row's force against what cancels in it
constexpr double stray = 1e-6;
constexpr double dependent = 1e-9;  ///< of motions that are combinations of others
constexpr std::size_t most_forces_told = 10;

/// sum_j |K_ij| m_j.
VectorXd absolute_product(const SparseMatrix& matrix, const VectorXd& magnitudes) {
  VectorXd sum = VectorXd::Zero(matrix.rows());
  for (Index j = 0; j < matrix.cols(); ++j)
    for (SparseMatrix::InnerIterator it(matrix, j); it; ++it) sum[it.row()] += std::abs(it.value()) * magnitudes[j];
  return sum;
}

/// Each row of K Q as a part of what cancels in it.
MatrixXd relative_forces(const SparseMatrix& stiffness, const MatrixXd& motions) {
  const VectorXd scale = absolute_product(stiffness, motions.rowwise().lpNorm<Eigen::Infinity>());
  const VectorXd inverse = (scale.array() > 0.0).select(scale.cwiseInverse(), 0.0);
  return inverse.asDiagonal() * (stiffness * motions);
}

/// R of F = Q R, with the singular values of F, which may have fewer rows than columns.
MatrixXd triangular_factor(const MatrixXd& forces) {
  const Index columns = forces.cols();
  MatrixXd padded = MatrixXd::Zero(std::max(forces.rows(), columns), columns);
  padded.topRows(forces.rows()) = forces;
  const Eigen::HouseholderQR<MatrixXd> qr(padded);
  return qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

}  // namespace

GroundingCheck check_grounding(const SparseMatrix& stiffness, const MatrixXd& rigid_motions,
                               const std::vector<bool>& held) {
  GroundingCheck grounding;
  const Index n = stiffness.rows();
  if (n == 0) {
    for (auto& motion : grounding.motions) motion.exists = false;
    return grounding;
  }
  const VectorXd sizes = rigid_motions.colwise().norm();
  const double largest = sizes.maxCoeff();
  for (Index d = 0; d < 6; ++d) {
    auto& motion = grounding.motions[static_cast<std::size_t>(d)];
    motion.exists = sizes[d] > dependent * largest;
    if (motion.exists) motion.largest = relative_forces(stiffness, rigid_motions.col(d)).cwiseAbs().maxCoeff();
    motion.strained = motion.largest > strain_rounding;
  }
  const MatrixXd scaled =
      rigid_motions * (sizes.array() > dependent * largest).select(sizes.cwiseInverse(), 0.0).matrix().asDiagonal();
  Eigen::ColPivHouseholderQR<MatrixXd> qr(scaled);
  qr.setThreshold(dependent);
  grounding.existing = static_cast<int>(qr.rank());
  if (grounding.existing == 0) return grounding;
  const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(n, qr.rank());
  const MatrixXd forces = relative_forces(stiffness, basis);
  const Eigen::JacobiSVD<MatrixXd> combinations(triangular_factor(forces));
  grounding.free = static_cast<int>((combinations.singularValues().array() < strain_rounding).count());
  for (Index i = 0; i < n; ++i)
    if (const double ratio = forces.row(i).cwiseAbs().maxCoeff(); ratio > stray && !held[static_cast<std::size_t>(i)])
      grounding.stray.push_back({i, ratio});
  grounding.stray_count = static_cast<Index>(grounding.stray.size());
  std::ranges::sort(grounding.stray, std::greater{}, &StrayForce::ratio);
  if (grounding.stray.size() > most_forces_told) grounding.stray.resize(most_forces_told);
  return grounding;
}

}  // namespace kalfem
