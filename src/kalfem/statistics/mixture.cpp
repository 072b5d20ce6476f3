// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/mixture.hpp"

namespace kalfem {

using Eigen::VectorXd;

VectorXd weights_of(const VectorXd& log_evidences) {
  const VectorXd relative = (log_evidences.array() - log_evidences.maxCoeff()).exp();
  return relative / relative.sum();
}

Mixture mixture_of(const std::vector<MixedModel>& models) {
  Mixture mixture;
  mixture.mean = mixture.deviation = VectorXd::Zero(models.front().mean.size());
  for (const auto& [weight, mean, deviation] : models)
    if (weight > 0.0) mixture.mean += weight * mean;
  for (const auto& [weight, mean, deviation] : models)
    if (weight > 0.0) mixture.deviation += weight * (deviation.cwiseAbs2() + (mean - mixture.mean).cwiseAbs2());
  mixture.deviation = mixture.deviation.cwiseSqrt();
  return mixture;
}

}  // namespace kalfem
