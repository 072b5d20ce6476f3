// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/last_consistent.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double most_remembered = 200.0;  ///< estimates that the mean square goes back over, about

/// Factors on the deviations of unknowns: `factor`, but not beyond the prior's deviation.
VectorXd factors(const VectorXd& variance, const VectorXd& prior, double factor) {
  return (variance.array() > 0.0)
      .select((prior.array() / variance.array().max(1e-300)).sqrt().min(factor).max(1.0),
              VectorXd::Ones(variance.size()));
}

}  // namespace

MatrixXd widened(const MatrixXd& covariance, double factor, Index first_unknown, const MatrixXd& prior) {
  VectorXd scale = VectorXd::Constant(covariance.rows(), factor);
  const Index rest = covariance.rows() - first_unknown;
  scale.tail(rest) = factors(covariance.diagonal().tail(rest), prior.diagonal().tail(rest), factor);
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

LastConsistent::LastConsistent(const AugmentedModel& model, const Gaussian& prior)
    : prior_{model.physical(prior.mean), model.physical_covariance(prior.covariance)},
      estimate_(prior_),
      mean_square_(VectorXd::Zero(prior.mean.size())) {}

void LastConsistent::remember(const AugmentedModel& model, const Gaussian& now) {
  estimate_ = {model.physical(now.mean), model.physical_covariance(now.covariance)};
  count_ = std::min(count_ + 1.0, most_remembered);
  mean_square_ += ((estimate_.mean - prior_.mean).cwiseAbs2() - mean_square_) / count_;
}

Gaussian LastConsistent::again(const AugmentedModel& model, double wider) const {
  const Index first = model.layout().unknown(), unknowns = model.layout().unknowns;
  Gaussian anew{prior_.mean, MatrixXd::Zero(prior_.mean.size(), prior_.mean.size())};
  // Everything but the unknowns: as far from its prior mean as it has been, and as uncertain.
  anew.covariance.diagonal() = mean_square_ + estimate_.covariance.diagonal();
  anew.mean.segment(first, unknowns) = estimate_.mean.segment(first, unknowns);
  const auto block = [&](const MatrixXd& of) { return of.block(first, first, unknowns, unknowns); };
  const VectorXd scale = factors(block(estimate_.covariance).diagonal(), block(prior_.covariance).diagonal(), wider);
  anew.covariance.block(first, first, unknowns, unknowns) =
      scale.asDiagonal() * block(estimate_.covariance) * scale.asDiagonal();
  return {model.own(anew.mean), model.own_covariance(anew.covariance)};
}

}  // namespace kalfem
