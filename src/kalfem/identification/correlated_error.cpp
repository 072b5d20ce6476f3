// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/correlated_error.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

IssueList validate(const CorrelatedError& error, double interval) {
  IssueList issues;
  if (!(interval > 0.0) || !std::isfinite(interval))
    issues.add({}, "the interval of the samples is " + shortest(interval) + " s", "it must be > 0", "");
  if (!(error.correlation_time >= 0.0) || !std::isfinite(error.correlation_time))
    issues.add({}, "the correlation time of an error is " + shortest(error.correlation_time) + " s",
               "it must be zero or positive", "use 0 for independent samples");
  if (error.deviation && (!(*error.deviation > 0.0) || !std::isfinite(*error.deviation)))
    issues.add({}, "the deviation of an error is " + shortest(*error.deviation), "it must be > 0",
               "leave it out to use its most likely value");
  return issues;
}

}  // namespace

// The innovations e_k of the autoregression are independent, so that the sum over them costs no matrix.
double log_density_of_correlated_series(const Eigen::Ref<const VectorXd>& series, double interval,
                                        const CorrelatedError& error) {
  validate(error, interval).raise();
  Index count = 0, last = 0;
  double squares = 0.0, log_variances = 0.0;  // sum e_k^2, sum ln(1 - phi^2)
  for (Index k = 0; k < series.size(); ++k) {
    if (std::isnan(series[k])) continue;
    double phi = 0.0, remaining = 1.0;  // 1 - phi^2
    if (count > 0 && error.correlation_time > 0.0) {
      const double steps = static_cast<double>(k - last) * interval / error.correlation_time;
      phi = std::exp(-steps);
      remaining = -std::expm1(-2.0 * steps);
    }
    const double departure = count > 0 ? series[k] - phi * series[last] : series[k];
    squares += departure * departure / remaining;
    log_variances += std::log(remaining);
    last = k;
    ++count;
  }
  if (count == 0 || !std::isfinite(squares)) return -infinity;
  const auto n = static_cast<double>(count);
  const double variance = error.deviation ? *error.deviation * *error.deviation : squares / n;
  const double quadratic = error.deviation ? squares / variance : n;
  return -0.5 * (n * std::log(2.0 * std::numbers::pi * variance) + quadratic + log_variances);
}

}  // namespace kalfem
