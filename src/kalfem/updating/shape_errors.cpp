// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/shape_errors.hpp"

#include <cmath>

namespace kalfem {
namespace {

std::vector<Eigen::Index> measured_entries(const Eigen::VectorXd& shape) {
  std::vector<Eigen::Index> entries;
  for (Eigen::Index i = 0; i < shape.size(); ++i)
    if (std::isfinite(shape[i])) entries.push_back(i);
  return entries;
}

}  // namespace

ShapeErrors::ShapeErrors(const Eigen::VectorXd& shape, const Eigen::VectorXd& deviations)
    : measured_(measured_entries(shape)), deviations_(deviations(measured_)) {}

ShapeErrors ShapeErrors::correlated(const Eigen::VectorXd& shape, const Eigen::MatrixXd& covariance) {
  constexpr double rounding = 1e-10;  // of the largest variance: below, a covariance of few blocks is singular
  ShapeErrors errors(shape, Eigen::VectorXd::Ones(shape.size()));
  const Eigen::VectorXd phi = shape(errors.measured_);
  Eigen::MatrixXd sigma = covariance(errors.measured_, errors.measured_);
  sigma += sigma.trace() / phi.squaredNorm() * phi * phi.transpose();
  sigma.diagonal().array() += rounding * sigma.diagonal().maxCoeff();
  errors.factor_.compute(sigma);
  errors.deviations_.resize(0);
  return errors;
}

ShapeErrors ShapeErrors::at_given_scale(const Eigen::VectorXd& shape, const Eigen::MatrixXd& covariance) {
  constexpr double least = 1e-4;
  ShapeErrors errors(shape, Eigen::VectorXd::Ones(shape.size()));
  Eigen::MatrixXd sigma = covariance(errors.measured_, errors.measured_);
  sigma.diagonal().array() += least * sigma.diagonal().maxCoeff();
  errors.factor_.compute(sigma);
  errors.deviations_.resize(0);
  return errors;
}

Eigen::MatrixXd ShapeErrors::whitened(const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd measured = of_measured(columns);
  if (deviations_.size() > 0) return deviations_.cwiseInverse().asDiagonal() * measured;
  return factor_.matrixL().solve(measured);
}

ShapeErrors shape_errors_of(const MeasuredMode& mode, ShapeScale scale) {
  if (mode.shape_covariance.size() > 0)
    return scale == ShapeScale::free ? ShapeErrors::correlated(mode.shape, mode.shape_covariance)
                                     : ShapeErrors::at_given_scale(mode.shape, mode.shape_covariance);
  if (mode.shape_deviations.size() > 0) return {mode.shape, mode.shape_deviations};
  return {mode.shape, Eigen::VectorXd::Constant(mode.shape.size(), mode.shape_deviation * largest_entry(mode.shape))};
}

}  // namespace kalfem
