// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Weights of models with these evidences and the same chance before, which sum up to 1.
Eigen::VectorXd weights_of(const Eigen::VectorXd& log_evidences);

/// What one model of a mixture says of some numbers: their means and standard deviations. They outlive the call.
struct MixedModel {
  double weight = 0.0;
  const Eigen::VectorXd& mean;
  const Eigen::VectorXd& deviation;
};

struct Mixture {
  Eigen::VectorXd mean, deviation;
};

/// Means and standard deviations over several models that may all be right,
///     mean = sum w_i m_i,    variance = sum w_i (s_i^2 + (m_i - mean)^2),
/// with weights that sum up to 1: what each model leaves open, and the spread between the models (law of total
/// variance). A model without weight may hold anything. All have the length of the first.
Mixture mixture_of(const std::vector<MixedModel>& models);

}  // namespace kalfem
