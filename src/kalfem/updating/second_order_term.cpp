// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/second_order_term.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The change of the gradient along a step serves as weight of the update if it grows by more than this part of s^T J^T
/// J s; otherwise J^T J s does.
constexpr double least_growth = 1e-3;
/// An eigenvalue of the Hessian, its diagonal scaled to one, that is smaller than this counts as zero.
constexpr double least_curvature = 1e-10;

}  // namespace

double QuadraticModel::reduction(const VectorXd& change) const {
  const VectorXd effect = matrix * change;
  return -effect.dot(offset + 0.5 * effect);
}

// 1. z, what S should give along s, is the change of the gradient less what the mean of J^T J explains of it.
// 2. S is multiplied by min(1, |s^T z| / |s^T S s|): near a small residual the second-order part vanishes faster than
//    updates alone could shrink it.
// 3. S + (w v^T + v w^T) / (v^T s) - (s^T w) v v^T / (v^T s)^2, with w = z - S s and the weight v.
MatrixXd updated_second_order(const MatrixXd& before, const VectorXd& step, const SecantEnd& begin,
                              const SecantEnd& end) {
  const Index count = step.size();
  MatrixXd second_order = before.size() > 0 ? before : MatrixXd(MatrixXd::Zero(count, count));
  const auto gradient = [](const SecantEnd& at) -> VectorXd {
    return at.jacobian_factor.transpose() * at.projected_residual;
  };
  const auto curvature = [&](const SecantEnd& at) -> VectorXd {
    return at.jacobian_factor.transpose() * (at.jacobian_factor * step);
  };
  const VectorXd growth = gradient(end) - gradient(begin), explained = 0.5 * (curvature(begin) + curvature(end));
  const VectorXd wanted = growth - explained;
  const double present = std::abs(step.dot(second_order * step)), due = std::abs(step.dot(wanted));
  if (present > due) second_order *= due / present;
  const VectorXd weight = growth.dot(step) > least_growth * explained.dot(step) ? growth : explained;
  const double along = weight.dot(step);
  if (!(along > 0.0)) return second_order;
  const VectorXd missing = wanted - second_order * step;
  second_order += (missing * weight.transpose() + weight * missing.transpose()) / along;
  second_order -= step.dot(missing) / (along * along) * weight * weight.transpose();
  return second_order;
}

// With H = D V diag(lambda) V^T D and D the root of its diagonal, A = diag(sqrt(lambda)) V^T D and b = A^-T g.
std::optional<QuadraticModel> with_second_order(const QuadraticModel& model, const MatrixXd& second_order) {
  const MatrixXd hessian = model.matrix.transpose() * model.matrix + second_order;
  if (!hessian.allFinite() || !(hessian.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const VectorXd root = hessian.diagonal().cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(root.cwiseInverse().asDiagonal() * hessian *
                                                      root.cwiseInverse().asDiagonal());
  if (!(eigen.eigenvalues().minCoeff() > least_curvature)) return std::nullopt;
  const VectorXd lengths = eigen.eigenvalues().cwiseSqrt();
  const MatrixXd rotation = eigen.eigenvectors().transpose();
  return QuadraticModel{lengths.asDiagonal() * rotation * root.asDiagonal(),
                        (rotation * model.gradient().cwiseQuotient(root)).cwiseQuotient(lengths)};
}

}  // namespace kalfem
