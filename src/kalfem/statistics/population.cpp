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
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

/// The posterior of tau on a grid that is even in ln tau. The means of the members are X beta, members x p; mu is
/// beta_0.
struct SpreadPosterior {
  ArrayXd estimates, variances;  ///< t_j, s_j^2
  ArrayXd tau, weights;          ///< the weights sum up to 1
  MatrixXd mean, variance;       ///< of beta, given tau: a row each

  SpreadPosterior(const std::vector<PopulationMember>& members, const MatrixXd& X)
      : estimates(std::ssize(members)), variances(std::ssize(members)) {
    for (Index j = 0; j < estimates.size(); ++j) {
      const auto& member = members[static_cast<std::size_t>(j)];
      estimates[j] = member.estimate;
      variances[j] = member.deviation * member.deviation;
    }
    make_grid();
    mean.resize(tau.size(), X.cols());
    variance.resize(tau.size(), X.cols());
    const double near = estimates.mean();  // taken off, so that no digits are lost
    ArrayXd log_density(tau.size());
    for (Index i = 0; i < tau.size(); ++i) {
      const VectorXd w = 1.0 / (variances + tau[i] * tau[i]);
      const Eigen::LLT<MatrixXd> information(X.transpose() * w.asDiagonal() * X);
      const VectorXd beta = information.solve(X.transpose() * w.cwiseProduct((estimates - near).matrix()));
      const VectorXd rest = (estimates - near).matrix() - X * beta;
      mean.row(i) = beta.transpose();
      variance.row(i) = information.solve(MatrixXd::Identity(X.cols(), X.cols())).diagonal().transpose();
      log_density[i] = 2.0 * std::log(tau[i]) + std::log(w.norm())  // the prior, per d ln tau
                       - information.matrixLLT().diagonal().array().log().sum() + 0.5 * w.array().log().sum() -
                       0.5 * rest.dot(w.cwiseProduct(rest));
    }
    mean.col(0).array() += near;
    weights = weights_of(log_density);
    leave_out_the_weightless();
  }

  void leave_out_the_weightless() {
    constexpr double weightless = 1e-13;
    std::vector<Index> kept;
    for (Index i = 0; i < tau.size(); ++i)
      if (weights[i] > weightless) kept.push_back(i);
    for (ArrayXd* values : {&tau, &weights}) *values = ArrayXd((*values)(kept));
    for (MatrixXd* values : {&mean, &variance}) *values = MatrixXd((*values)(kept, Eigen::all));
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

  [[nodiscard]] PopulationEstimate spread(double probability) const {
    const double outside = 0.5 * (1.0 - probability);
    return {spread_quantile(0.5), {spread_quantile(outside), spread_quantile(1.0 - outside)}};
  }

  [[nodiscard]] NormalMixture coefficient(Index k) const {
    return {weights, mean.col(k).array(), variance.col(k).array().sqrt()};
  }

  /// theta_j given tau, with mu integrated out: (t_j tau^2 + mu s_j^2) / (tau^2 + s_j^2).
  [[nodiscard]] NormalMixture member(Index j) const {
    const ArrayXd squared = tau.square(), lean = variances[j] / (squared + variances[j]);
    return {weights, estimates[j] + lean * (mean.col(0).array() - estimates[j]),
            (lean * squared + lean.square() * variance.col(0).array()).sqrt()};
  }
};

/// 1 and the covariates about their means, in units of their own spread.
struct Design {
  MatrixXd X;
  VectorXd units;

  explicit Design(const MatrixXd& covariates) : X(covariates.rows(), covariates.cols() + 1), units(covariates.cols()) {
    const MatrixXd about = covariates.rowwise() - covariates.colwise().mean();
    units = about.colwise().norm().transpose() / std::sqrt(static_cast<double>(covariates.rows()));
    X << VectorXd::Ones(covariates.rows()), about * units.cwiseInverse().asDiagonal();
  }

  [[nodiscard]] bool is_determined() const {
    constexpr double apart = 1e-6;
    return X.allFinite() &&
           Eigen::JacobiSVD<MatrixXd>(X).singularValues().minCoeff() > apart * std::sqrt(static_cast<double>(X.rows()));
  }
};

PopulationEstimate scaled(const PopulationEstimate& told, double factor) {
  return {told.median * factor, {told.interval[0] * factor, told.interval[1] * factor}};
}

}  // namespace

NormalPopulation population_of(const std::vector<PopulationMember>& members, double probability) {
  check(members, probability);
  const SpreadPosterior posterior(members, MatrixXd::Ones(std::ssize(members), 1));
  NormalPopulation population;
  population.mean = posterior.coefficient(0).told(probability);
  population.spread = posterior.spread(probability);
  population.next = NormalMixture{posterior.weights, posterior.mean.col(0).array(),
                                  (posterior.variance.col(0).array() + posterior.tau.square()).sqrt()}
                        .told(probability);
  for (Index j = 0; j < std::ssize(members); ++j) population.members.push_back(posterior.member(j).told(probability));
  return population;
}

PopulationTrend population_trend(const std::vector<PopulationMember>& members, const MatrixXd& covariates,
                                 double probability) {
  check(members, probability);
  const auto count = std::ssize(members);
  if (covariates.rows() != count)
    throw InvalidInput(fmt::format("{} rows of covariates for {} members", covariates.rows(), count),
                       "each member has its own", "give one row a member");
  if (!covariates.allFinite()) throw InvalidInput("a covariate is not finite", "the mean follows it", "");
  if (count < covariates.cols() + 2)
    throw InvalidInput(fmt::format("{} members and {} covariates", count, covariates.cols()),
                       "mean, slopes and spread need two members more than covariates",
                       "give more members or fewer covariates");
  const Design design(covariates);
  if (!design.is_determined())
    throw InvalidInput("a covariate is the same for all members, or follows from the others",
                       "its slope cannot be told", "leave it out");
  const SpreadPosterior posterior(members, design.X);
  PopulationTrend trend{posterior.coefficient(0).told(probability), {}, posterior.spread(probability)};
  for (Index k = 0; k < design.units.size(); ++k)
    trend.slopes.push_back(scaled(posterior.coefficient(k + 1).told(probability), 1.0 / design.units[k]));
  return trend;
}

}  // namespace kalfem
