#include "kalfem/estimation/covariance_factor.hpp"

#include <cmath>

#include "kalfem/estimation/small_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double negative_variance_tolerance = 1e-9;
constexpr double rounding = 1e-13;  ///< a pivot that lost all digits: the matrix is singular

bool semidefinite_factor(const MatrixXd& covariance, MatrixXd& factor) {
  if (!covariance.triangularView<Eigen::Lower>().toDenseMatrix().allFinite()) return false;
  const VectorXd deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (covariance.diagonal().minCoeff() < 0.0) return false;
  const VectorXd scale = (deviation.array() > 0.0).select(deviation.cwiseInverse(), 0.0);
  MatrixXd correlation = covariance.selfadjointView<Eigen::Lower>();
  correlation = scale.asDiagonal() * correlation * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(correlation);
  if (eigen.info() != Eigen::Success || eigen.eigenvalues()[0] < -negative_variance_tolerance) return false;
  const VectorXd roots = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  MatrixXd transposed = roots.asDiagonal() * eigen.eigenvectors().transpose();
  triangularise(transposed, factor);
  factor = deviation.asDiagonal() * factor;
  return factor.allFinite();
}

}  // namespace

bool covariance_factor(const MatrixXd& covariance, MatrixXd& factor) {
  return cholesky(covariance, rounding, factor) || semidefinite_factor(covariance, factor);
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
