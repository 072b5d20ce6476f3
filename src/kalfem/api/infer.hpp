// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "kalfem/api/estimate.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/identification/inference_choices.hpp"
#include "kalfem/sampling/marginal_prior.hpp"
#include "kalfem/sampling/posterior_mode.hpp"

namespace kalfem {

/// What a record shall tell of unknown parameters, and how. Everything left out of the model is zero, as in
/// EstimateOptions.
struct InferOptions {
  std::vector<SensorDescription> sensors;
  /// Their priors are those of an estimation: normal, log-normal under `log`, cut at the bounds of `logit`.
  std::vector<UnknownDescription> unknowns;
  /// Priors of any shape in the place of those, by unknown [its unit]. The search then starts at the prior's median
  /// unless the unknown says more.
  std::vector<std::pair<std::string, MarginalPrior>> priors = {};
  /// Unknowns whose posterior is sought; empty: all that do not drift. The filter integrates the others out.
  std::vector<std::string> parameters = {};

  LikelihoodKind likelihood = LikelihoodKind::filter;  ///< of the record: `filter` or `simulation`
  double correlation_time = 0.0;  ///< of the error that a simulation leaves [s]; 0: independent from sample to sample
  PosteriorMethod method = PosteriorMethod::importance;
  int samples = 1000;                     ///< of the posterior, 50 or more
  std::uint64_t seed = 1;                 ///< of these; the same seed gives the same bits
  std::vector<std::string> profile = {};  ///< parameters whose profile likelihood is computed
  int predictions = 40;                   ///< draws whose response is simulated; 0: no predictive bands

  /// Prior of the initial motion, by degree of freedom; "all" for those without an entry.
  std::vector<std::pair<std::string, PointPrior>> initial_state = {};
  bool initial_state_from_record = false;  ///< displacements and velocities from the displacement sensors
  double process_noise = 0.0;              ///< white acceleration on every degree of freedom [m/s^2/sqrt(Hz)]
  std::optional<FilterKind> filter = {};   ///< if empty, the structure decides
  /// How well numbers are known that are held fixed: the posterior integrates them out.
  std::vector<KnownTo> known_to = {};
  std::optional<int> substeps = {};  ///< of a sample interval; empty: as many as the estimates need
  int threads = 0;                   ///< 0: one per processor; results do not depend on it
  Progress progress = {};
};

/// The marginal posterior of a parameter, in its unit. Not a number where the method found no distribution: Laplace's
/// at a maximum without curvature.
struct PosteriorParameter {
  using Interval = ParameterEstimate::Interval;

  static constexpr double unknown_number = std::numeric_limits<double>::quiet_NaN();

  std::string name, unit;
  double mean = unknown_number, std = unknown_number, median = unknown_number;
  Interval interval_68 = {unknown_number, unknown_number},
           interval_95 = interval_68;  ///< between quantiles of the samples
  double most_probable = 0.0;          ///< at the largest p(y | theta) p(theta) found
  double prior_mean = 0.0, prior_std = 0.0;
  std::optional<double> r_hat = {};              ///< of Markov chains: they have met below 1.01
  std::optional<double> effective_samples = {};  ///< of Markov chains, in the centre
};

/// ln p(y | theta) along one parameter, the others at their most likely values.
struct ParameterProfile {
  std::string name, unit;
  Eigen::VectorXd values;              ///< ascending [unit]
  Eigen::VectorXd log_likelihood;      ///< less the largest one; -infinity where there is none
  std::optional<double> lower, upper;  ///< 95 % interval; empty where the profile has not fallen by 1.92
};

/// Response at draws of the posterior, sample by sample.
struct ResponseBand {
  std::string sensor, unit;
  Eigen::VectorXd mean;
  Eigen::VectorXd lower, upper;  ///< 95 %, with the sensor's noise
  double coverage = 0.0;         ///< share of the measured samples inside
};

/// The posterior of a record, p(theta | y) = p(y | theta) p(theta) / Z.
struct InferResult {
  std::vector<PosteriorParameter> parameters;  ///< in the order of the unknowns
  Eigen::MatrixXd samples;                     ///< theta, parameters x samples
  Eigen::VectorXd weights;                     ///< of each sample, their sum is one
  Eigen::VectorXd log_likelihood, log_prior;   ///< of each sample
  Eigen::Index chains = 1;                     ///< Markov chains; equally long, one after the other
  Eigen::MatrixXd correlation;                 ///< of the parameters in the posterior
  std::optional<double> log_evidence;          ///< ln Z; empty where the method gives none
  std::optional<double> log_evidence_std;      ///< of ln Z: of the samples, and what substeps bias it by
  std::string method, likelihood;              ///< in words
  std::optional<double> effective_samples;     ///< that the weighted samples are worth
  std::optional<double> pareto_k;              ///< of their weights; above 0.7 they do not hold
  long long evaluations = 0;                   ///< of the likelihood
  std::vector<PosteriorMode> modes;            ///< two or more where the posterior has several, the heaviest first
  std::string foreseen;                        ///< what the record could tell before it was looked at, in words
  std::string identifiability;                 ///< what it tells of combinations of parameters, in words
  std::vector<ParameterProfile> profiles;      ///< in the order in which they were asked for
  std::vector<ResponseBand> bands;             ///< one a sensor; empty where the response cannot be simulated
  std::vector<std::string> warnings;           ///< why the posterior may not hold, in words

  /// Look-up by name; throws InvalidInput if there is none.
  [[nodiscard]] const PosteriorParameter& parameter(const std::string& name) const;
};

/// The posterior of the unknowns of a structure by a record, whose channels have the sensors' names, in SI units. It is
/// what `infer` of a case gives: a search from the estimates of the filter, then samples by the method. Throws
/// InvalidInput with every argument that is wrong, by its place ("priors[0] 'mount.k': ..."), and where no start has a
/// likelihood. What the numbers do is in the result.
InferResult infer(const Structure& structure, const Record& record, const InferOptions& options);

/// The posterior of parameters of linear substructures by what an updating compares: modes with the covariances of
/// their shapes, frequency responses, deflections. The likelihood is that of the N weighted residuals r in their
/// standard deviations,
///     ln p = -|r|^2 / 2 - N/2 ln(2 pi).
/// Priors: `options.priors` by parameter, else normal about the initial value with the parameter's `std`, cut at its
/// bounds, else uniform between finite bounds. `options.likelihood` must be `comparisons`; of the rest of the options
/// method (not `filter`), samples, seed, profile and progress count. Throws InvalidInput as update() does, for a
/// parameter without a prior, and for options that have no meaning here.
InferResult infer(const Structure& structure, const UpdateOptions& comparisons, const InferOptions& options);

}  // namespace kalfem
