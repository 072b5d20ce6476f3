// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/evidence.hpp"

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

double log_sum_exp(const Eigen::Ref<const Eigen::VectorXd>& x) {
  if (x.size() == 0) return -std::numeric_limits<double>::infinity();
  const double largest = x.maxCoeff();
  if (!std::isfinite(largest)) return largest;
  return largest + std::log((x.array() - largest).exp().sum());
}

Eigen::VectorXd model_probabilities(const Eigen::Ref<const Eigen::VectorXd>& log_evidence,
                                    const Eigen::Ref<const Eigen::VectorXd>& prior) {
  for (const double value : log_evidence)
    if (std::isnan(value) || value == std::numeric_limits<double>::infinity())
      throw InvalidInput("a log evidence is not a number", "models cannot be compared by it", "leave that model out");
  if (prior.size() != 0 && (prior.size() != log_evidence.size() || !(prior.array() >= 0.0).all()))
    throw InvalidInput("prior probabilities of the models do not fit", "one for each model, none negative",
                       "give one for each model, or none for equal ones");
  Eigen::VectorXd log_weight = log_evidence;
  if (prior.size() != 0) log_weight += prior.array().log().matrix();
  const double total = log_sum_exp(log_weight);
  if (!std::isfinite(total))
    throw InvalidInput("no model is possible", "every evidence is zero", "check the models and their priors");
  return log_weight.unaryExpr([total](double each) { return std::exp(each - total); });  // to zero, where Eigen's stops
}

std::string kass_raftery(double log_bayes_factor) {
  const double twice = 2.0 * std::abs(log_bayes_factor);
  if (twice < 2.0) return "not worth more than a bare mention";
  if (twice < 6.0) return "positive";
  return twice < 10.0 ? "strong" : "very strong";
}

}  // namespace kalfem
