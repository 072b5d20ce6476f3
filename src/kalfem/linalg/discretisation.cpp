// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/discretisation.hpp"

#include <cmath>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/scaling.hpp"

namespace kalfem {

using Eigen::MatrixXd;

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

/// e^(Ah) and h phi_j(Ah) B, j = 1 ... count.
struct PhiProducts {
  MatrixXd exponential;
  std::vector<MatrixXd> products;
};

// One exponential gives the transition and the weights of x' = A x + B u with u a polynomial over the step [VL78]:
//     exp [A h, B h, 0; 0, 0, 1; 0, 0, 0] = [e^(Ah), h phi_1(Ah) B, h phi_2(Ah) B; ...],
// one block row more for each further power. States are balanced and inputs scaled by powers of two before: the
// exponential's squarings then follow the frequencies and not the units, and scaling back is exact.
PhiProducts phi_products(const Eigen::Ref<const MatrixXd>& A, const Eigen::Ref<const MatrixXd>& B, double h,
                         Eigen::Index count) {
  const Eigen::Index n = A.rows(), m = B.cols();
  if (n == 0) return {A, std::vector<MatrixXd>(static_cast<std::size_t>(count), B)};

  const Eigen::VectorXd d = balancing_scale(A);
  const MatrixXd balanced_input = d.cwiseInverse().asDiagonal() * B * h;
  const Eigen::RowVectorXd e = input_scale(balanced_input);

  MatrixXd augmented = MatrixXd::Zero(n + count * m, n + count * m);
  augmented.topLeftCorner(n, n) = d.cwiseInverse().asDiagonal() * A * d.asDiagonal() * h;
  augmented.block(0, n, n, m) = balanced_input * e.asDiagonal();
  for (Eigen::Index j = 1; j < count; ++j) augmented.block(n + (j - 1) * m, n + j * m, m, m).setIdentity();
  const MatrixXd exponential = augmented.exp();

  PhiProducts all{d.asDiagonal() * exponential.topLeftCorner(n, n) * d.cwiseInverse().asDiagonal(), {}};
  const Eigen::RowVectorXd unscale = e.cwiseInverse();
  for (Eigen::Index j = 0; j < count; ++j)
    all.products.emplace_back(d.asDiagonal() * exponential.block(0, n + j * m, n, m) * unscale.asDiagonal());
  return all;
}

}  // namespace

FirstOrderHold first_order_hold(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
                                double h) {
  check(A, B, h);
  const auto [exponential, P] = phi_products(A, B, h, 2);
  return {exponential, P[0] - P[1], P[1]};
}

// Over the first half a0 = u0, a1 = (4 u_m - 3 u0 - u1) / 2, over the second a0 = u_m, a1 = (u1 - u0) / 2, and
// a2 = u0 - 2 u_m + u1 over both.
QuadraticHold quadratic_hold(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
                             double h) {
  check(A, B, h);
  const auto [half, P] = phi_products(A, B, 0.5 * h, 3);
  const QuadraticHold::Instant middle{half, P[0] - 1.5 * P[1] + P[2], 2.0 * (P[1] - P[2]), P[2] - 0.5 * P[1]};
  const QuadraticHold::Instant end{half * half, half * middle.begin_weight + P[2] - 0.5 * P[1],
                                   half * middle.middle_weight + P[0] - 2.0 * P[2],
                                   half * middle.end_weight + P[2] + 0.5 * P[1]};
  return {middle, end, half * middle.end_weight + middle.end_weight};
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
