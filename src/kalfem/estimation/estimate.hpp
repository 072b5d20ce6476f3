// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/estimation/adaptive_noise.hpp"
#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/estimation/unknowns_history.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// An unknown that may take another value at a sample: what was learned of it before counts less from there on.
struct Renewal {
  Eigen::Index unknown = 0;  ///< its place among all unknowns
  Eigen::Index sample = 0;   ///< the first one with the new value
  double deviation = 0.0;    ///< of the change, in the filter's state
};

struct EstimationOptions {
  FilterKind filter = FilterKind::unscented;
  UnscentedOptions unscented = {};
  int threads = 1;  ///< of the filter, where it is partially linear and large; results do not depend on it
  int passes = 1;   ///< runs over the record; each further one starts from the last one's parameters, under
                    ///< narrow_prior() or, with AugmentedModelOptions::keep_initial_state, from its initial state too
                    ///< under the first prior's covariance
  /// Means of every state at every sample, beside those of unknowns and internal states; without them at the last one.
  bool state_means = true;
  /// Standard deviations of every state at every sample, beside those of unknowns and internal states. In modal
  /// coordinates they cost more than the filter does.
  bool state_deviations = true;
  /// Samples from one computation of the monitored quantities' standard deviations to the next; they stand in between.
  int deviation_stride = 1;
  bool keep_gains = false;     ///< of every sample in the result, see run_with_gains()
  bool keep_unknowns = false;  ///< their history in the result, for deviations that hold where the model is not exact
  /// What the embedded step of order 2 would shift in the unknowns, in the result (StepShift), for a step of order 4.
  bool step_shift = false;
  /// Factor F of what the covariance of the constant unknowns lacks, F F^T, in the filter's state, c x any: what this
  /// adds to the monitored quantities is then in the result (deviation_of_excess()).
  Eigen::MatrixXd excess = {};
  AdaptiveNoiseOptions adaptive_noise = {};
  OutlierOptions outliers = {};               ///< what the updates do with samples far from their prediction
  std::vector<HeldOutSamples> held_out = {};  ///< samples to predict only
  std::vector<Renewal> renewals = {};         ///< changes of unknowns that the run allows for
  OutputMap monitored = {};  ///< further quantities to estimate at every sample, without measurement chains
  Progress progress = {};
};

/// What a filter runs over: what its sensors recorded and what drove the structure.
struct FilterInput {
  Record measured;         ///< one channel a sensor, in the model's order
  Eigen::MatrixXd inputs;  ///< [r; r'; r''], 3 n_u x samples, or at every instant, 3 n_u x ((samples - 1) instants + 1)
  Eigen::MatrixXd noise;   ///< R, l x l

  /// y_k: the sample as the filter sees it; not a number where it is missing, and behind what the filter learns from.
  void sample(Eigen::Index k, Eigen::VectorXd& y) const;
  /// Columns of the inputs from one sample to the next, AugmentedModelOptions::instants() or one.
  [[nodiscard]] Eigen::Index input_stride(Eigen::Index instants) const {
    return inputs.cols() > measured.samples() ? instants : 1;
  }
};

/// Mean and standard deviation of some quantities at every sample.
struct EstimatedSeries {
  Eigen::MatrixXd mean;       ///< quantities x samples
  Eigen::MatrixXd deviation;  ///< quantities x samples
};

/// Why a run ended early.
struct EstimationFailure {
  FilterOutcome outcome = FilterOutcome::usable;
  double time = 0.0;          ///< from the first sample [s]
  std::string reason;         ///< in words: the outcome and its likeliest cause
  std::string subject = {};   ///< the channel, unknown or connector that it comes from, where one stands out
  std::string cause = {};     ///< in words, from the samples before
  std::string remedy = {};    ///< in words, without what the run does already
  Eigen::Index computed = 0;  ///< samples that the result holds
};

/// Channels up to which a run keeps the covariances of their innovations.
inline constexpr Eigen::Index most_covariances = 16;

/// The noise of a run that adapts it. It is that in force at a sample: learned before it.
struct NoiseCourse {
  Eigen::MatrixXd sensors;             ///< standard deviation, l x samples
  bool sensors_adapt = false;          ///< otherwise they are as stated
  Eigen::VectorXd process_factor;      ///< on the covariance of the white accelerations; empty: as stated
  double density = 0.0;                ///< of these at factor one, the largest of a point [m/s^2/sqrt(Hz)]
  bool density_is_stated = false;      ///< otherwise zero was stated, and this is where it started
  Eigen::VectorXd sensor_uncertainty;  ///< standard deviation of ln(standard deviation of a sensor) at the end
  double process_uncertainty = 0.0;    ///< standard deviation of ln(factor) at the end

  [[nodiscard]] double density_at(Eigen::Index k) const { return density * std::sqrt(process_factor[k]); }
};

/// Wall time of the last run over the record [s].
struct EstimationTime {
  double predict = 0.0, update = 0.0;
  double output = 0.0;  ///< storing results, monitored quantities among them

  [[nodiscard]] double filter() const { return predict + update; }
};

/// Everything that a run of the filter over a record gives. After a failure the samples from there on are not a
/// number.
struct EstimationResult {
  Gaussian prior;         ///< of the augmented state, in the augmented model's coordinates: with it the last run began
  EstimatedSeries state;  ///< the augmented state, after the update; see StateLayout
  EstimatedSeries unknowns;  ///< in the parameters' own units
  EstimatedSeries monitored;
  Eigen::MatrixXd monitored_excess;  ///< deviations that EstimationOptions::excess adds, quantities x samples
  Eigen::MatrixXd step_shift;        ///< of the unknowns, in their own units, unknowns x samples; where it is asked for
  Eigen::MatrixXd innovation;        ///< l x samples, NaN where missing
  Eigen::MatrixXd innovation_deviation;  ///< l x samples
  /// Its covariance's lower triangle row by row, l (l + 1) / 2 x samples, NaN where missing; empty for more than
  /// `most_covariances` channels.
  Eigen::MatrixXd innovation_covariance;
  Eigen::VectorXd nis;          ///< per sample, NaN if nothing was measured
  Eigen::VectorXi measured;     ///< channels measured per sample
  Eigen::VectorXd log_density;  ///< of each sample given those before, 0 if nothing was measured
  double log_likelihood = 0.0;  ///< their sum
  /// Samples that counted less or not at all: outliers, and those held out. No innovation above belongs to one left
  /// out.
  std::vector<SetAsideSample> set_aside;
  std::optional<NoiseCourse> noise;  ///< where it adapts
  Gains gains;                       ///< where they are asked for
  UnknownsHistory unknowns_history;  ///< where it is asked for
  Eigen::MatrixXd final_covariance;  ///< of the augmented state
  std::optional<EstimationFailure> failure;
  EstimationTime time;
  /// About the last values of the unknowns of the linear part, and how often it was relinearised; empty where it
  /// never was.
  std::shared_ptr<const AugmentedModel> augmented_model;
  int linearisations = 0;
};

/// Whether the filter learned from each channel's sample as from any other, l x samples: 0 where it is missing, was set
/// aside, or the filter had stopped.
Eigen::MatrixXi used_samples(const EstimationResult& result);

/// Checks the options against this augmented model: the weights of the sigma points, and passes that need an initial
/// state.
IssueList validate(const AugmentedModel& augmented_model, const EstimationOptions& options);

/// Runs the filter over the record. Throws InvalidInput where sizes do not fit or an input is not finite.
EstimationResult estimate(const AugmentedModel& augmented_model, const FilterInput& input,
                          const EstimationOptions& options);

/// Interval that holds `probability` of a parameter's distribution (normal in the filter's state) about its estimate.
struct Interval {
  double lower = 0.0, upper = 0.0;
};
Interval confidence_interval(const ParameterTransform& transform, double state_mean, double state_deviation,
                             double probability = 0.95);

}  // namespace kalfem
