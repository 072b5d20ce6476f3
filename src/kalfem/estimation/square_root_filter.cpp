// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/square_root_filter.hpp"

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/covariance_filter.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Not a number where the noise is no covariance: the next outcome then says so.
MatrixXd root_of(const MatrixXd& noise) {
  MatrixXd root;
  if (!covariance_factor(noise, root)) root = MatrixXd::Constant(noise.rows(), noise.cols(), NAN);
  return root;
}

}  // namespace

// A step (arrays in the header, [KSH00] chapter 12): stack the columns that make up the new covariance, transposed, and
// triangularise them by QR; S is read off the triangle. A scatter Sigma with negative directions is split by its
// eigenvalues: positive ones join the stack, negative ones are taken off the triangle by downdates.
SquareRootFilter::SquareRootFilter(const FilterModel& model, UnscentedTransform transform)
    : Filter(model), transform_(std::move(transform)), process_root_(root_of(model.process_noise)) {}

void SquareRootFilter::set_process_noise(const MatrixXd& noise) {
  Filter::set_process_noise(noise);
  process_root_ = root_of(noise);
}

void SquareRootFilter::reset(const Gaussian& estimate) {
  mean_ = estimate.mean;
  array_ = root_of(estimate.covariance).transpose();
  triangularise(array_, factor_);
}

void SquareRootFilter::keep(ArchiveWriter& archive) const {
  archive(mean_);
  archive(factor_);
}

void SquareRootFilter::take_up(ArchiveReader& archive) {
  archive(mean_);
  archive(factor_);
}

/// G Sigma G^T = added added^T - removed removed^T from the eigenvalues of the small Sigma.
bool SquareRootFilter::split_scatter(const PartiallyLinearMap& map) {
  if (transform_.scatter().size() == 0) {  // of a linear map, which the solver does not take
    added_ = removed_ = MatrixXd(map.gain().rows(), 0);
    return true;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(transform_.scatter());
  if (eigen.info() != Eigen::Success) return false;
  const auto& values = eigen.eigenvalues();
  // Negative ones that are rounding are none: a state that is known exactly could not be downdated by them.
  const double rounding = 1e-12 * values.cwiseAbs().maxCoeff();
  const Index negative = (values.array() < -rounding).count();
  VectorXd roots = values.cwiseMax(0.0).cwiseSqrt();
  roots.head(negative) = (-values.head(negative)).cwiseSqrt();
  const MatrixXd columns = map.gain() * eigen.eigenvectors() * roots.asDiagonal();
  removed_ = columns.leftCols(negative);
  added_ = columns.rightCols(columns.cols() - negative);
  return true;
}

FilterOutcome SquareRootFilter::predict() {
  if (!factor_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  if (!transform_.apply(process(), mean_, factor_, FactorShape::lower_triangular) || !split_scatter(process()))
    return FilterOutcome::model_not_evaluable;
  const auto& deviations = transform_.deviations();
  const Index n = deviations.rows();
  array_.resize(deviations.cols() + added_.cols() + process_root_.cols(), n);
  array_ << deviations.transpose(), added_.transpose(), process_root_.transpose();
  triangularise(array_, triangle_);
  for (Index j = 0; j < removed_.cols(); ++j)
    if (!downdate(triangle_, removed_.col(j))) return FilterOutcome::covariance_not_positive_definite;
  if (!triangle_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  mean_ = transform_.mean();
  factor_ = triangle_;
  return FilterOutcome::usable;
}

/// The array [D_y G Sigma^(1/2) R^(1/2); S 0 0] of the measured channels, transposed.
void SquareRootFilter::stack_measurement(const std::vector<Index>& present, const MatrixXd& noise) {
  if (noise_root_of_.rows() != noise.rows() || noise_root_of_ != noise) {
    noise_root_of_ = noise;
    noise_root_ = root_of(noise);
  }
  const Index l = noise.rows(), n = mean_.size();
  array_.setZero(n + added_.cols() + l, l + n);
  array_.topLeftCorner(n, l) = transform_.deviations()(present, Eigen::all).transpose();
  array_.topRightCorner(n, n) = factor_.transpose();
  array_.block(n, 0, added_.cols(), l) = added_(present, Eigen::all).transpose();
  array_.bottomLeftCorner(l, l) = noise_root_.transpose();
  // With fewer rows than columns the last columns of the triangle are zero.
  if (array_.rows() < array_.cols()) array_.conservativeResizeLike(MatrixXd::Zero(array_.cols(), array_.cols()));
}

FilterOutcome SquareRootFilter::expect(const VectorXd& y, const MatrixXd& noise, Innovation& innovation) {
  if (!factor_.allFinite()) return FilterOutcome::covariance_not_positive_definite;
  if (!transform_.apply(measurement(), mean_, factor_, FactorShape::lower_triangular) || !split_scatter(measurement()))
    return FilterOutcome::model_not_evaluable;
  const auto& present = innovation.channels;
  innovation.value = y - transform_.mean()(present);
  const MatrixXd own = transform_.deviations()(present, Eigen::all), added = added_(present, Eigen::all),
                 removed = removed_(present, Eigen::all);
  innovation.covariance = noise + own * own.transpose() + added * added.transpose() - removed * removed.transpose();
  return FilterOutcome::usable;
}

/// The triangle [L_y 0; J S+] of the update. False where a downdate or a variance is impossible.
bool SquareRootFilter::triangularise_measurement(const std::vector<Index>& present, const MatrixXd& noise) {
  const Index l = noise.rows(), n = mean_.size();
  stack_measurement(present, noise);
  triangularise(array_, triangle_);
  VectorXd column = VectorXd::Zero(l + n);
  for (Index j = 0; j < removed_.cols(); ++j) {
    column.head(l) = removed_(present, j);
    if (!downdate(triangle_, column)) return false;
  }
  return triangle_.allFinite() && triangle_.diagonal().head(l).minCoeff() > 0.0;
}

FilterOutcome SquareRootFilter::correct(const MatrixXd& noise, Innovation& innovation) {
  const Index l = noise.rows(), n = mean_.size();
  if (!triangularise_measurement(innovation.channels, noise)) return FilterOutcome::innovation_not_positive_definite;
  const MatrixXd innovation_root = triangle_.topLeftCorner(l, l);
  innovation.covariance = innovation_root * innovation_root.transpose();
  VectorXd whitened = innovation_root.triangularView<Eigen::Lower>().solve(innovation.value);
  score(innovation, innovation_root, whitened);
  if (update_iterations() > 1) {
    if (!iterate(noise, innovation)) return FilterOutcome::innovation_not_positive_definite;
    whitened = triangle_.topLeftCorner(l, l).triangularView<Eigen::Lower>().solve(innovation.conditioned_value());
  }
  mean_ += triangle_.bottomLeftCorner(n, l) * whitened;
  factor_ = triangle_.bottomRightCorner(n, n);
  return FilterOutcome::usable;
}

/// The triangle again, about the posterior; where it is impossible there, about the prediction as before.
bool SquareRootFilter::iterate(const MatrixXd& noise, Innovation& innovation) {
  const auto& present = innovation.channels;
  const Index l = noise.rows();
  const UnscentedTransform predicted = transform_;
  iterated_.refine({measurement(), mean_, factor_, present, measured_values(), noise}, update_iterations(), transform_);
  innovation.relinearised = split_scatter(measurement()) && triangularise_measurement(present, noise);
  if (innovation.relinearised) {
    const MatrixXd root = triangle_.topLeftCorner(l, l);
    innovation.about_posterior = {measured_values() - transform_.mean()(present), root * root.transpose()};
    return true;
  }
  transform_ = predicted;
  return split_scatter(measurement()) && triangularise_measurement(present, noise);
}

/// From the triangle [L_y 0; J S+] of the update.
MatrixXd SquareRootFilter::gain() const {
  const Index n = mean_.size(), l = triangle_.rows() - n;
  return gain_from(triangle_.bottomLeftCorner(n, l), triangle_.topLeftCorner(l, l));
}

FilterOutcome SquareRootFilter::observe(VectorXd& mean, VectorXd* deviation) {
  auto& map = monitored();
  if (!transform_.apply(map, mean_, factor_, FactorShape::lower_triangular)) return FilterOutcome::model_not_evaluable;
  mean = transform_.mean();
  if (!deviation) return FilterOutcome::usable;
  MatrixXd covariance = MatrixXd::Zero(mean.size(), mean.size());
  transform_.add_covariance(map, covariance);
  *deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

}  // namespace kalfem
