// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/covariance_factor.hpp"

#include <cmath>

#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double negative_variance_tolerance = 1e-9;
constexpr double least_pivot = 1e-13;  ///< one below it has lost all digits: the matrix is singular

// First the plain Cholesky factorisation. A pivot that has lost all its digits means states known exactly: then the
// pivoted one, on the correlation matrix so that units do not matter.
/// Cholesky with diagonal pivoting on the correlation matrix, Higham, Accuracy and Stability of Numerical Algorithms,
/// section 10.3: columns until what is left of every variance is rounding; then made triangular.
bool semidefinite_factor(const MatrixXd& covariance, MatrixXd& factor) {
  const Index n = covariance.rows();
  if (!covariance.triangularView<Eigen::Lower>().toDenseMatrix().allFinite()) return false;
  if (n > 0 && covariance.diagonal().minCoeff() < 0.0) return false;
  const VectorXd deviation = covariance.diagonal().cwiseSqrt();
  const VectorXd scale = (deviation.array() > 0.0).select(deviation.cwiseInverse(), 0.0);
  MatrixXd correlation = covariance.selfadjointView<Eigen::Lower>();
  correlation = scale.asDiagonal() * correlation * scale.asDiagonal();
  VectorXd left = correlation.diagonal();
  factor.setZero(n, n);
  for (Index k = 0; k < n; ++k) {
    Index pivot = 0;
    if (left.maxCoeff(&pivot) <= least_pivot) break;
    factor.col(k) = correlation.col(pivot) - factor.leftCols(k) * factor.row(pivot).head(k).transpose();
    factor.col(k) /= std::sqrt(left[pivot]);
    left -= factor.col(k).cwiseAbs2();
    left[pivot] = 0.0;
  }
  if (n > 0 && !(left.minCoeff() > -negative_variance_tolerance)) return false;
  MatrixXd array = factor.transpose() * deviation.asDiagonal();
  triangularise(array, factor);
  return factor.allFinite();
}

}  // namespace

bool covariance_factor(const MatrixXd& covariance, MatrixXd& factor) {
  return cholesky(covariance, least_pivot, factor) || semidefinite_factor(covariance, factor);
}

void triangularise(MatrixXd& array, MatrixXd& lower) {
  const Index n = array.cols();
  Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(array);
  lower.resize(n, n);
  lower.setZero();
  for (Index j = 0; j < n; ++j) {
    const double sign = array(j, j) < 0.0 ? -1.0 : 1.0;
    lower.col(j).tail(n - j) = sign * array.row(j).tail(n - j).transpose();
  }
}

bool downdate(MatrixXd& lower, VectorXd vector) {
  const Index n = lower.rows();
  MatrixXd result = lower;
  for (Index k = 0; k < n; ++k) {
    const double diagonal = result(k, k), difference = (diagonal - vector[k]) * (diagonal + vector[k]);
    if (vector[k] == 0.0) continue;
    if (!(difference > 0.0)) return false;
    const double root = std::sqrt(difference), cosine = root / diagonal, sine = vector[k] / diagonal;
    result(k, k) = root;
    const Index below = n - k - 1;
    result.col(k).tail(below) = (result.col(k).tail(below) - sine * vector.tail(below)) / cosine;
    vector.tail(below) = cosine * vector.tail(below) - sine * result.col(k).tail(below);
  }
  lower = result;
  return true;
}

}  // namespace kalfem
