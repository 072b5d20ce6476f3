// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/window_information.hpp"

namespace kalfem {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd inverse(const MatrixXd& covariance) {
  return covariance.ldlt().solve(MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

}  // namespace

WindowInformation window_information(const Gaussian& start, const VectorXd& walk, const Gaussian& end) {
  constexpr double rounding = 1e-10;  // of the information that is subtracted
  // In units of the deviations before, in which the information that is subtracted is of the order of one.
  const MatrixXd before = start.covariance + MatrixXd(walk.asDiagonal());
  const VectorXd unit = before.diagonal().cwiseSqrt();
  const VectorXd per_unit = unit.cwiseInverse();
  const MatrixXd known = inverse(per_unit.asDiagonal() * before * per_unit.asDiagonal());
  const MatrixXd all = inverse(per_unit.asDiagonal() * end.covariance * per_unit.asDiagonal());
  const VectorXd moved = end.mean - start.mean;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(all - known);
  const MatrixXd& directions = eigen.eigenvectors();
  const VectorXd gained =
      (eigen.eigenvalues().array() > rounding * known.norm()).select(eigen.eigenvalues(), VectorXd::Zero(unit.size()));
  // eta = Lambda m_0 + P_1^-1 (m_1 - m_0), in the directions that hold information.
  const VectorXd shift = directions.transpose() * (all * per_unit.cwiseProduct(moved));
  const VectorXd told = (gained.array() > 0.0).select(shift, 0.0);
  const MatrixXd information = directions * gained.asDiagonal() * directions.transpose();
  return {per_unit.asDiagonal() * information * per_unit.asDiagonal(),
          per_unit.cwiseProduct(information * per_unit.cwiseProduct(start.mean) + directions * told)};
}

}  // namespace kalfem
