#include "kalfem/linalg/first_order_hold.hpp"

#include <cmath>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/balancing.hpp"

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

}  // namespace kalfem
