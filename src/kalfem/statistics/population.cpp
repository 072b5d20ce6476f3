// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/population.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/statistics/mixture.hpp"

namespace kalfem {

namespace {

using Eigen::ArrayXd;
using Eigen::Index;

void check(const std::vector<PopulationMember>& members, double probability) {
  IssueList issues;
  if (members.size() < 2)
    issues.add({}, fmt::format("a population of {} members", members.size()),
               "how much they differ is seen from two on", "give more runs");
  for (std::size_t j = 0; j < members.size(); ++j) {
    if (!std::isfinite(members[j].estimate))
      issues.add({}, fmt::format("the estimate of member {} is not finite", j + 1));
    if (!(members[j].deviation > 0.0) || !std::isfinite(members[j].deviation))
      issues.add({}, fmt::format("the standard deviation of member {} is not positive", j + 1));
  }
  if (!(probability > 0.0 && probability < 1.0)) issues.add({}, "the probability must lie between 0 and 1");
  issues.raise();
}

/// Normal distributions, one a value of tau.
struct NormalMixture {
  const ArrayXd& weights;
  ArrayXd means, deviations;

  [[nodiscard]] double below(double x) const {
    return (weights * 0.5 *
            ((means - x) / (deviations * std::sqrt(2.0))).unaryExpr([](double z) { return std::erfc(z); }))
        .sum();
  }

  /// By bisection between the means +- 40 deviations, which hold all that a double can tell.
  [[nodiscard]] double quantile(double probability) const {
    double low = (means - 40.0 * deviations).minCoeff(), high = (means + 40.0 * deviations).maxCoeff();
    for (int i = 0; i < 200 && low < high; ++i) {
      const double middle = low + 0.5 * (high - low);
      if (middle <= low || middle >= high) break;
      (below(middle) < probability ? low : high) = middle;
    }
    return high;
  }

  [[nodiscard]] PopulationEstimate told(double probability) const {
    const double outside = 0.5 * (1.0 - probability);
    return {quantile(0.5), {quantile(outside), quantile(1.0 - outside)}};
  }
};

/// The posterior of tau on a grid that is even in ln tau, with mu's mean and variance at each point.
struct SpreadPosterior {
  ArrayXd estimates, variances;  ///< t_j, s_j^2
  ArrayXd tau, weights;          ///< the weights sum up to 1
  ArrayXd mean, variance;        ///< of mu, given tau

  explicit SpreadPosterior(const std::vector<PopulationMember>& members)
      : estimates(std::ssize(members)), variances(std::ssize(members)) {
    for (Index j = 0; j < estimates.size(); ++j) {
      const auto& member = members[static_cast<std::size_t>(j)];
      estimates[j] = member.estimate;
      variances[j] = member.deviation * member.deviation;
    }
    make_grid();
    mean = variance = ArrayXd(tau.size());
    ArrayXd log_density(tau.size());
    for (Index i = 0; i < tau.size(); ++i) {
      const ArrayXd w = 1.0 / (variances + tau[i] * tau[i]);
      variance[i] = 1.0 / w.sum();
      mean[i] = estimates[0] + variance[i] * (w * (estimates - estimates[0])).sum();
      const double squares = (w * (estimates - mean[i]).square()).sum();
      log_density[i] = 2.0 * std::log(tau[i]) + 0.5 * std::log(w.square().sum())  // the prior, per d ln tau
                       + 0.5 * std::log(variance[i]) + 0.5 * w.log().sum() - 0.5 * squares;
    }
    weights = weights_of(log_density);
    leave_out_the_weightless();
  }

  void leave_out_the_weightless() {
    constexpr double weightless = 1e-13;
    std::vector<Index> kept;
    for (Index i = 0; i < tau.size(); ++i)
      if (weights[i] > weightless) kept.push_back(i);
    for (ArrayXd* values : {&tau, &weights, &mean, &variance}) *values = ArrayXd((*values)(kept));
    weights /= weights.sum();
  }

  /// From where no tau matters beside the errors to where the tail, tau^(1 - n), holds less than 1e-6 of two members.
  void make_grid() {
    constexpr Index points = 1200;
    constexpr double beside = 1e-4, beyond = 1e6;
    const double least = std::sqrt(variances.minCoeff());
    const double most = std::max(std::sqrt(variances.maxCoeff()), estimates.maxCoeff() - estimates.minCoeff());
    tau = ArrayXd::LinSpaced(points, std::log(beside * least), std::log(beyond * most)).exp();
  }

  [[nodiscard]] double spread_quantile(double probability) const {
    double sum = 0.0;
    for (Index i = 0; i + 1 < tau.size(); ++i) {
      const double within = 0.5 * (weights[i] + weights[i + 1]);
      if (sum + within >= probability) return tau[i] * std::pow(tau[i + 1] / tau[i], (probability - sum) / within);
      sum += within;
    }
    return tau[tau.size() - 1];
  }

  /// theta_j given tau, with mu integrated out: (t_j tau^2 + mu s_j^2) / (tau^2 + s_j^2).
  [[nodiscard]] NormalMixture member(Index j) const {
    const ArrayXd squared = tau.square(), lean = variances[j] / (squared + variances[j]);
    return {weights, estimates[j] + lean * (mean - estimates[j]), (lean * squared + lean.square() * variance).sqrt()};
  }
};

}  // namespace

NormalPopulation population_of(const std::vector<PopulationMember>& members, double probability) {
  check(members, probability);
  const SpreadPosterior posterior(members);
  const double outside = 0.5 * (1.0 - probability);
  NormalPopulation population;
  population.mean = NormalMixture{posterior.weights, posterior.mean, posterior.variance.sqrt()}.told(probability);
  population.spread = {posterior.spread_quantile(0.5),
                       {posterior.spread_quantile(outside), posterior.spread_quantile(1.0 - outside)}};
  population.next =
      NormalMixture{posterior.weights, posterior.mean, (posterior.variance + posterior.tau.square()).sqrt()}.told(
          probability);
  for (Index j = 0; j < std::ssize(members); ++j) population.members.push_back(posterior.member(j).told(probability));
  return population;
}

}  // namespace kalfem
