// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace kalfem {
namespace {

Eigen::VectorXd weights_of(const SampleSet& samples) {
  if (samples.weights.size() > 0) return samples.weights;
  const Eigen::Index count = samples.values.cols();
  return Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
}

/// Quantiles of weighted values: the weight of a value is spread evenly about its middle.
class WeightedQuantiles {
public:
  WeightedQuantiles(const Eigen::VectorXd& values, const Eigen::VectorXd& weights) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return values[a] < values[b]; });
    double below = 0.0;
    for (const auto i : order) {
      values_.push_back(values[i]);
      middles_.push_back(below + 0.5 * weights[i]);
      below += weights[i];
    }
  }

  double operator()(double probability) const {
    const auto above = std::lower_bound(middles_.begin(), middles_.end(), probability);
    if (above == middles_.begin()) return values_.front();
    if (above == middles_.end()) return values_.back();
    const auto k = static_cast<std::size_t>(above - middles_.begin());
    const double width = middles_[k] - middles_[k - 1];
    const double part = width > 0.0 ? (probability - middles_[k - 1]) / width : 1.0;
    return values_[k - 1] + part * (values_[k] - values_[k - 1]);
  }

private:
  std::vector<double> values_, middles_;
};

}  // namespace

double Posterior::log_likelihood_at(const Eigen::VectorXd& theta) const {
  const double value = log_likelihood(theta);
  return std::isnan(value) ? -std::numeric_limits<double>::infinity() : value;
}

double Posterior::log_likelihood_of(const Eigen::VectorXd& z) const {
  return log_likelihood_at(prior.from_standard_normal(z));
}

Eigen::MatrixXd SampleSet::draws_of(Eigen::Index parameter) const {
  return values.row(parameter).transpose().reshaped(draws, chains);
}

SampleSet make_sample_set(const JointPrior& prior, const Eigen::MatrixXd& z, const Eigen::VectorXd& log_likelihood,
                          Eigen::Index chains) {
  SampleSet set;
  set.log_likelihood = log_likelihood;
  set.chains = chains;
  set.draws = z.cols() / chains;
  for (const auto& [name, marginal] : prior.marginals()) set.names.push_back(name);
  set.values.resize(z.rows(), z.cols());
  set.log_prior.resize(z.cols());
  for (Eigen::Index k = 0; k < z.cols(); ++k) {
    const Eigen::VectorXd theta = prior.from_standard_normal(z.col(k));
    set.values.col(k) = theta;
    set.log_prior[k] = prior.log_density(theta);
  }
  return set;
}

SampleSet resample(const SampleSet& samples, Eigen::Index count, std::uint64_t seed) {
  if (samples.values.cols() == 0 || count < 1)
    throw InvalidInput(std::to_string(count) + " draws of " + std::to_string(samples.values.cols()) + " samples",
                       "at least one of each is needed", "ask for at least one draw");
  const Eigen::VectorXd weights = weights_of(samples);
  const double offset = RandomStream(seed, "resampling").uniform(), total = weights.sum();
  std::vector<Eigen::Index> chosen;
  Eigen::Index last = 0;  // with a weight
  for (Eigen::Index i = 0; i < weights.size(); ++i)
    if (weights[i] > 0.0) last = i;
  double reached = weights[0];
  for (Eigen::Index k = 0, i = 0; k < count; ++k) {
    const double place = (static_cast<double>(k) + offset) / static_cast<double>(count) * total;
    while (place >= reached && i < last) reached += weights[++i];
    chosen.push_back(i);
  }
  return {.names = samples.names,
          .values = samples.values(Eigen::all, chosen),
          .log_likelihood = samples.log_likelihood(chosen),
          .log_prior = samples.log_prior(chosen),
          .weights = {},
          .chains = 1,
          .draws = count};
}

std::vector<ParameterSummary> summarise_samples(const SampleSet& samples) {
  const Eigen::VectorXd weights = weights_of(samples);
  const Eigen::VectorXd mean = samples.values * weights;
  const Eigen::VectorXd deviation = posterior_covariance(samples).diagonal().cwiseSqrt();
  std::vector<ParameterSummary> summaries;
  for (Eigen::Index i = 0; i < samples.values.rows(); ++i) {
    const WeightedQuantiles quantile(samples.values.row(i), weights);
    summaries.push_back({samples.names[static_cast<std::size_t>(i)], mean[i], deviation[i], quantile(0.025),
                         quantile(0.16), quantile(0.5), quantile(0.84), quantile(0.975)});
  }
  return summaries;
}

Eigen::MatrixXd posterior_covariance(const SampleSet& samples) {
  const Eigen::VectorXd weights = weights_of(samples);
  const Eigen::MatrixXd centred = samples.values.colwise() - Eigen::VectorXd(samples.values * weights);
  return centred * weights.asDiagonal() * centred.transpose() / (1.0 - weights.squaredNorm());
}

Eigen::MatrixXd posterior_correlation(const SampleSet& samples) {
  Eigen::MatrixXd correlation = posterior_covariance(samples);
  Eigen::VectorXd inverse = correlation.diagonal().cwiseSqrt();
  for (auto& value : inverse) value = value > 0.0 ? 1.0 / value : 0.0;
  correlation = inverse.asDiagonal() * correlation * inverse.asDiagonal();
  correlation.diagonal().setOnes();
  return correlation;
}

}  // namespace kalfem
