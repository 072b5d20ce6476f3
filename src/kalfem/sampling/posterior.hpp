// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kalfem/sampling/prior.hpp"

namespace kalfem {

/// ln p(data | theta); -infinity, or not a number, where the model is impossible. Called from several threads.
using LogLikelihood = std::function<double(const Eigen::VectorXd& theta)>;

/// p(theta | data) = p(data | theta) p(theta) / Z.
struct Posterior {
  JointPrior prior;
  LogLikelihood log_likelihood;

  /// ln p(data | theta), -infinity for what is not a number.
  [[nodiscard]] double log_likelihood_at(const Eigen::VectorXd& theta) const;
  /// The same at the standard normal z of the prior.
  [[nodiscard]] double log_likelihood_of(const Eigen::VectorXd& z) const;
};

/// Draws from a posterior. Column c * draws + k is draw k of chain c, as ArviZ's InferenceData(chain, draw) asks.
struct SampleSet {
  std::vector<std::string> names;  ///< p
  Eigen::MatrixXd values;          ///< theta, p x (chains * draws)
  Eigen::VectorXd log_likelihood;  ///< of each sample
  Eigen::VectorXd log_prior;       ///< of each sample
  Eigen::VectorXd weights;         ///< that sum to one; empty: all equal
  Eigen::Index chains = 1;         ///< 1 where samples have no order in time, such as those of TMCMC
  Eigen::Index draws = 0;          ///< of each chain

  /// One parameter, draws x chains.
  [[nodiscard]] Eigen::MatrixXd draws_of(Eigen::Index parameter) const;
};

/// Samples at the columns of z, p x (chains * draws).
SampleSet make_sample_set(const JointPrior& prior, const Eigen::MatrixXd& z, const Eigen::VectorXd& log_likelihood,
                          Eigen::Index chains);

/// `count` draws with equal weights from weighted samples, by systematic resampling: sample i is drawn n w_i times,
/// rounded down or up (Kitagawa 1996, J. Comput. Graph. Stat. 5, 1-25). Equal weights are thinned, or repeated, evenly.
/// Throws InvalidInput where there is no sample or `count` is below one.
SampleSet resample(const SampleSet& samples, Eigen::Index count, std::uint64_t seed = 1);

/// Marginal posterior of one parameter.
struct ParameterSummary {
  std::string name;
  double mean = 0.0;
  double deviation = 0.0;
  double q2_5 = 0.0;  ///< quantiles at 2.5, 16, 50, 84 and 97.5 %
  double q16 = 0.0;
  double median = 0.0;
  double q84 = 0.0;
  double q97_5 = 0.0;
};

/// Weighted moments and quantiles of each parameter.
std::vector<ParameterSummary> summarise_samples(const SampleSet& samples);
/// Correlation of the parameters in the posterior, p x p; zero beside a parameter that does not vary.
Eigen::MatrixXd posterior_correlation(const SampleSet& samples);
/// Weighted covariance, p x p.
Eigen::MatrixXd posterior_covariance(const SampleSet& samples);

}  // namespace kalfem
