// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/discretisation.hpp"

#include <cmath>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/scaling.hpp"

namespace kalfem {

namespace {

void check(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B, double h) {
  IssueList issues;
  if (A.rows() != A.cols() || B.rows() != A.rows())
    issues.add({},
               "first-order hold of a " + std::to_string(A.rows()) + " x " + std::to_string(A.cols()) +
                   " matrix A and " + std::to_string(B.rows()) + " rows of B",
               "A must be square with as many rows as B");
  if (!(h > 0.0) || !std::isfinite(h))
    issues.add({}, "first-order hold over h = " + std::to_string(h) + " s", "the interval must be positive and finite");
  if (!A.allFinite() || !B.allFinite())
    issues.add({}, "first-order hold of a matrix with infinite or undefined entries",
               "every entry of A and B must be finite");
  issues.raise();
}

/// Powers of two that bring each input's column to norm <= 1, so that large inputs do not cost squarings.
Eigen::RowVectorXd input_scale(const Eigen::MatrixXd& B) {
  return B.colwise().lpNorm<Eigen::Infinity>().unaryExpr(
      [](double norm) { return norm > 0.0 ? std::exp2(-std::ceil(std::log2(norm))) : 1.0; });
}

}  // namespace

// One exponential gives the transition and both weights of x' = A x + B u with u linear over the step [VL78]:
//     exp [A h, B h, 0; 0, 0, 1; 0, 0, 0] = [e^(Ah), G, G1; ...],    x1 = e^(Ah) x0 + (G - G1) u0 + G1 u1.
// States are balanced and inputs scaled by powers of two before: the exponential's squarings then follow the
// frequencies and not the units, and scaling back is exact.
FirstOrderHold first_order_hold(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
                                double h) {
  check(A, B, h);
  const Eigen::Index n = A.rows();
  const Eigen::Index m = B.cols();
  if (n == 0) return {A, B, B};

  const Eigen::VectorXd d = balancing_scale(A);
  const Eigen::MatrixXd balanced_input = d.cwiseInverse().asDiagonal() * B * h;
  const Eigen::RowVectorXd e = input_scale(balanced_input);

  Eigen::MatrixXd augmented = Eigen::MatrixXd::Zero(n + 2 * m, n + 2 * m);
  augmented.topLeftCorner(n, n) = d.cwiseInverse().asDiagonal() * A * d.asDiagonal() * h;
  augmented.block(0, n, n, m) = balanced_input * e.asDiagonal();
  augmented.block(n, n + m, m, m).setIdentity();
  const Eigen::MatrixXd exponential = augmented.exp();

  const Eigen::RowVectorXd unscale = e.cwiseInverse();
  const Eigen::MatrixXd G = d.asDiagonal() * exponential.block(0, n, n, m) * unscale.asDiagonal();
  const Eigen::MatrixXd G1 = d.asDiagonal() * exponential.block(0, n + m, n, m) * unscale.asDiagonal();
  return {d.asDiagonal() * exponential.topLeftCorner(n, n) * d.cwiseInverse().asDiagonal(), G - G1, G1};
}

namespace {

void check_density(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& Qc, double h) {
  IssueList issues;
  if (A.rows() != A.cols() || Qc.rows() != A.rows() || Qc.cols() != A.cols())
    issues.add({},
               "process noise of a " + std::to_string(A.rows()) + " x " + std::to_string(A.cols()) +
                   " matrix A and a " + std::to_string(Qc.rows()) + " x " + std::to_string(Qc.cols()) + " density",
               "both must be square and of the same size");
  if (!(h > 0.0) || !std::isfinite(h))
    issues.add({}, "process noise over h = " + std::to_string(h) + " s", "the interval must be positive and finite");
  if (!A.allFinite() || !Qc.allFinite())
    issues.add({}, "process noise of a matrix with infinite or undefined entries",
               "every entry of A and Qc must be finite");
  issues.raise();
}

struct NoiseStep {
  Eigen::MatrixXd transition;
  Eigen::MatrixXd covariance;
};

// The covariance of process noise over a step is int e^(As) Qc e^(A^T s) ds. Van Loan's block exponential [VL78] gives
// it with the transition, but holds e^(-Ah), which is huge for a long step of a stiff structure. So it is taken over a
// step short enough that the norm is below 1/2, and the step is doubled until it is the whole one.
/// Van Loan's block exponential over a short step, A and Q already multiplied by its length.
NoiseStep short_step(const Eigen::MatrixXd& A, const Eigen::MatrixXd& Q) {
  const Eigen::Index n = A.rows();
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  block.topLeftCorner(n, n) = -A;
  block.topRightCorner(n, n) = Q;
  block.bottomRightCorner(n, n) = A.transpose();
  const Eigen::MatrixXd exponential = block.exp();
  const Eigen::MatrixXd transition = exponential.bottomRightCorner(n, n).transpose();
  return {transition, transition * exponential.topRightCorner(n, n)};
}

NoiseStep doubled(const NoiseStep& step) {
  return {step.transition * step.transition,
          step.covariance + step.transition * step.covariance * step.transition.transpose()};
}

int halvings_until_short(double norm) {
  constexpr double short_norm = 0.5;
  return norm > short_norm ? static_cast<int>(std::ceil(std::log2(norm) - std::log2(short_norm))) : 0;
}

}  // namespace

Eigen::MatrixXd process_noise_covariance(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                         const Eigen::Ref<const Eigen::MatrixXd>& Qc, double h) {
  check_density(A, Qc, h);
  if (A.size() == 0 || Qc.isZero(0.0)) return Eigen::MatrixXd::Zero(A.rows(), A.cols());

  const Eigen::VectorXd d = balancing_scale(A);
  const Eigen::VectorXd inverse = d.cwiseInverse();
  const Eigen::MatrixXd balanced = inverse.asDiagonal() * A * d.asDiagonal();
  const Eigen::MatrixXd density = inverse.asDiagonal() * Qc * inverse.asDiagonal();
  const double density_norm = density.lpNorm<Eigen::Infinity>();

  const int halvings = halvings_until_short(balanced.cwiseAbs().colwise().sum().maxCoeff() * h);
  const double h0 = std::ldexp(h, -halvings);
  NoiseStep step = short_step(balanced * h0, density / density_norm);
  step.covariance *= density_norm * h0;
  for (int k = 0; k < halvings; ++k) step = doubled(step);

  const Eigen::MatrixXd covariance = d.asDiagonal() * step.covariance * d.asDiagonal();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace kalfem
