#include "kalfem/estimation/square_root_filter.hpp"

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/covariance_filter.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void SquareRootFilter::reset(const Gaussian& estimate) {
  mean_ = estimate.mean;
  MatrixXd root;
  if (!covariance_factor(estimate.covariance, root)) root = MatrixXd::Constant(mean_.size(), mean_.size(), NAN);
  array_ = root.transpose();
  triangularise(array_, factor_);
}

/// Square root of a noise covariance, formed anew only when the covariance changes.
const MatrixXd& SquareRootFilter::root_of(const MatrixXd& noise, MatrixXd& kept, MatrixXd& root) {
  if (kept.rows() != noise.rows() || kept != noise) {
    kept = noise;
    if (!covariance_factor(noise, root)) root = MatrixXd::Constant(noise.rows(), noise.cols(), NAN);
  }
  return root;
}

/// G Sigma G^T = added added^T - removed removed^T from the eigenvalues of the small Sigma.
bool SquareRootFilter::split_scatter(const PartiallyLinearMap& map) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(transform_.scatter());
  if (eigen.info() != Eigen::Success) return false;
  const auto& values = eigen.eigenvalues();
  // Negative ones that are rounding are none: a state that is known exactly could not be downdated by them.
  const double rounding = values.size() > 0 ? 1e-12 * values.cwiseAbs().maxCoeff() : 0.0;
  const Index negative = (values.array() < -rounding).count();
  VectorXd roots = values.cwiseMax(0.0).cwiseSqrt();
  roots.head(negative) = (-values.head(negative)).cwiseSqrt();
  const MatrixXd columns = map.gain * eigen.eigenvectors() * roots.asDiagonal();
  removed_ = columns.leftCols(negative);
  added_ = columns.rightCols(columns.cols() - negative);
  return true;
}

FilterOutcome SquareRootFilter::predict(PartiallyLinearMap& transition, const MatrixXd& process_noise) {
  if (!factor_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  if (!transform_.apply(transition, mean_, factor_, FactorShape::lower_triangular) || !split_scatter(transition))
    return FilterOutcome::model_not_evaluable;
  const MatrixXd& noise_root = root_of(process_noise, process_noise_, process_root_);
  const auto& deviations = transform_.deviations();
  const Index n = deviations.rows();
  array_.resize(deviations.cols() + added_.cols() + noise_root.cols(), n);
  array_ << deviations.transpose(), added_.transpose(), noise_root.transpose();
  triangularise(array_, triangle_);
  for (Index j = 0; j < removed_.cols(); ++j)
    if (!downdate(triangle_, removed_.col(j))) return FilterOutcome::covariance_not_positive_definite;
  if (!triangle_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  mean_ = transform_.mean();
  factor_ = triangle_;
  return FilterOutcome::usable;
}

FilterOutcome SquareRootFilter::update(PartiallyLinearMap& measurement, const MatrixXd& noise, const VectorXd& y,
                                       Innovation& innovation) {
  if (!factor_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  if (!transform_.apply(measurement, mean_, factor_, FactorShape::lower_triangular) || !split_scatter(measurement))
    return FilterOutcome::model_not_evaluable;
  const MatrixXd& noise_root = root_of(noise, noise_, noise_root_);
  const auto& deviations = transform_.deviations();
  const Index l = y.size(), n = mean_.size();
  array_.setZero(n + added_.cols() + l, l + n);
  array_.topLeftCorner(n, l) = deviations.transpose();
  array_.topRightCorner(n, n) = factor_.transpose();
  array_.block(n, 0, added_.cols(), l) = added_.transpose();
  array_.bottomLeftCorner(l, l) = noise_root.transpose();
  // With fewer rows than columns the last columns of the triangle are zero.
  if (array_.rows() < array_.cols()) array_.conservativeResizeLike(MatrixXd::Zero(array_.cols(), array_.cols()));
  triangularise(array_, triangle_);
  VectorXd column = VectorXd::Zero(l + n);
  for (Index j = 0; j < removed_.cols(); ++j) {
    column.head(l) = removed_.col(j);
    if (!downdate(triangle_, column)) return FilterOutcome::innovation_not_positive_definite;
  }
  const MatrixXd innovation_root = triangle_.topLeftCorner(l, l);
  if (!triangle_.allFinite() || !(innovation_root.diagonal().minCoeff() > 0.0))
    return FilterOutcome::innovation_not_positive_definite;
  innovation.value = y - transform_.mean();
  innovation.covariance = innovation_root * innovation_root.transpose();
  const VectorXd whitened = innovation_root.triangularView<Eigen::Lower>().solve(innovation.value);
  score(innovation, innovation_root, whitened);
  mean_ += triangle_.bottomLeftCorner(n, l) * whitened;
  factor_ = triangle_.bottomRightCorner(n, n);
  return FilterOutcome::usable;
}

FilterOutcome SquareRootFilter::observe(PartiallyLinearMap& map, VectorXd& mean, VectorXd* deviation) {
  if (!transform_.apply(map, mean_, factor_, FactorShape::lower_triangular)) return FilterOutcome::model_not_evaluable;
  mean = transform_.mean();
  if (!deviation) return FilterOutcome::usable;
  MatrixXd covariance = MatrixXd::Zero(mean.size(), mean.size());
  transform_.add_covariance(map, covariance);
  *deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

}  // namespace kalfem
