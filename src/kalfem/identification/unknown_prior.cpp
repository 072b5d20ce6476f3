// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/unknown_prior.hpp"

namespace kalfem {

namespace {

LogNormalPrior lognormal_about(double median, double deviation) {
  return {.median = median, .log_deviation = deviation / median};
}

}  // namespace

MarginalPrior prior_of(const Unknown& unknown) {
  const auto& transform = unknown.transform;
  if (transform.kind == TransformKind::log) return lognormal_about(unknown.initial, unknown.deviation);
  NormalPrior prior{.mean = unknown.initial, .deviation = unknown.deviation};
  if (transform.kind == TransformKind::logit) {
    prior.lower = transform.lower;
    prior.upper = transform.upper;
  }
  return prior;
}

/// Gains and noise are positive, and their initial value is the median.
MarginalPrior prior_of(const LikelihoodUnknown& unknown) {
  const bool by_logarithm = !unknown.is_of_clock() && unknown.initial > 0.0;
  if (by_logarithm) return lognormal_about(unknown.initial, unknown.deviation);
  return NormalPrior{.mean = unknown.initial, .deviation = unknown.deviation};
}

}  // namespace kalfem
