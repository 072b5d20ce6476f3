// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/pareto_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "kalfem/sampling/evidence.hpp"

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Eigen::Index fewest = 5;  ///< values that a fit needs

/// k that maximises the likelihood for theta = -k / sigma: the mean of ln(1 - theta x).
double shape_at(double theta, const Eigen::Ref<const Eigen::VectorXd>& x) {
  return (-theta * x.array()).log1p().mean();
}

std::vector<Eigen::Index> ascending(const Eigen::VectorXd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return values[a] < values[b]; });
  return order;
}

}  // namespace

double GeneralisedPareto::quantile(double probability) const {
  const double survival = std::log1p(-probability);
  return std::abs(shape) < 1e-12 ? -scale * survival : scale * std::expm1(-shape * survival) / shape;
}

GeneralisedPareto fit_generalised_pareto(const Eigen::Ref<const Eigen::VectorXd>& sorted) {
  const auto count = static_cast<double>(sorted.size());
  const int points = 30 + static_cast<int>(std::sqrt(count));
  const double quartile = sorted[static_cast<Eigen::Index>(count / 4.0 + 0.5) - 1];
  Eigen::VectorXd theta(points), log_profile(points);
  for (int j = 0; j < points; ++j) {
    theta[j] = 1.0 / sorted[sorted.size() - 1] + (1.0 - std::sqrt(points / (j + 0.5))) / (3.0 * quartile);
    const double k = shape_at(theta[j], sorted);
    log_profile[j] = count * (std::log(-theta[j] / k) - k - 1.0);  // theta and k differ in sign
    if (std::isnan(log_profile[j])) log_profile[j] = -infinity;
  }
  const Eigen::ArrayXd posterior = (log_profile.array() - log_sum_exp(log_profile)).exp();
  const double mean = (theta.array() * posterior).sum();
  const double k = shape_at(mean, sorted);
  return {.shape = k, .scale = -k / mean};
}

SmoothedWeights smooth_weights(const Eigen::VectorXd& log_weights) {
  SmoothedWeights smoothed{.log_weights = log_weights};
  const auto count = static_cast<double>(log_weights.size());
  const auto tail = static_cast<Eigen::Index>(std::ceil(std::min(0.2 * count, 3.0 * std::sqrt(count))));
  const double largest = log_weights.size() > 0 ? log_weights.maxCoeff() : -infinity;
  if (!std::isfinite(largest) || tail < fewest) return {.log_weights = log_weights, .k_hat = infinity};
  const auto order = ascending(log_weights);
  const auto first = static_cast<Eigen::Index>(order.size()) - tail;  // of the tail
  const double threshold = std::exp(log_weights[order[static_cast<std::size_t>(first - 1)]] - largest);
  if (threshold > 1.0 - 1e-10) return smoothed;

  std::vector<Eigen::Index> above;
  for (auto k = static_cast<std::size_t>(first); k < order.size(); ++k)
    if (std::exp(log_weights[order[k]] - largest) - threshold > 1e-300) above.push_back(order[k]);
  const auto size = static_cast<Eigen::Index>(above.size());
  if (size < fewest) return {.log_weights = log_weights, .k_hat = infinity};
  const Eigen::VectorXd excess = (log_weights(above).array() - largest).exp() - threshold;
  GeneralisedPareto fit = fit_generalised_pareto(excess);
  const auto number = static_cast<double>(size);
  fit.shape = (number * fit.shape + 10.0 * 0.5) / (number + 10.0);
  smoothed.k_hat = fit.shape;
  for (Eigen::Index j = 0; j < size; ++j) {
    const double value = threshold + fit.quantile((static_cast<double>(j) + 0.5) / number);
    smoothed.log_weights[above[static_cast<std::size_t>(j)]] = largest + std::min(0.0, std::log(value));
  }
  return smoothed;
}

double k_hat_limit(Eigen::Index samples) { return std::min(1.0 - 1.0 / std::log10(static_cast<double>(samples)), 0.7); }

}  // namespace kalfem
