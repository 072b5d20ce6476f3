// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/smoother/smoother.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"
#include "kalfem/identification/parameter_jumps.hpp"
#include "kalfem/identification/process_noise_study.hpp"
#include "kalfem/identification/sensor_events.hpp"
#include "kalfem/identification/unknown_inputs.hpp"

namespace kalfem {

/// What follows the first answer of an estimation: it is not asked for, to come, at its end, or ended before that.
enum class SecondThoughts { none, pending, done, stopped };

/// "pending" and so on.
std::string to_string(SecondThoughts thoughts);

struct FixedNumberStudy;
struct FreedNumbers;
struct HeldOutStudy;
struct NumberTrials;
struct UnknownInformation;

/// What a filter's run over a record gives: the estimates with both their deviations, whether the innovations are
/// consistent, and the record again from the estimates alone.
struct RecordEstimate {
  FilterKind filter = FilterKind::unscented;
  std::string filter_reason;            ///< why this filter was chosen, in a sentence
  std::vector<FilterAttempt> attempts;  ///< every filter that was tried, the one that is used among them
  SubstepChoice substeps;               ///< of a sample interval in the filter's model
  RecordStart start;                    ///< what the filter assumed of the motion at the first sample
  std::shared_ptr<const AugmentedModel> augmented_model;
  EstimationResult result;
  /// Gains, delays and noise that were found by maximum likelihood, if any were unknown.
  std::optional<LikelihoodEstimate> likelihood;
  /// Of the sensors that the augmented model uses, without their gains and delays, and without the samples of faults.
  Record measurements;
  OutlierTreatment outliers = OutlierTreatment::keep;  ///< in the run that gave the result
  std::vector<HeldOutSamples> held_out = {};           ///< in it
  std::vector<SensorEvent> events = {};                ///< what is wrong with the record or missing in it
  std::optional<ParameterJump> jump = {};              ///< a constant unknown that changes within the record
  Eigen::Index settled = 0;                            ///< first sample of the error and consistency figures
  ConsistencySummary consistency;
  /// With other process noise, this estimate among them; empty where there is nothing to compare.
  std::vector<ProcessNoiseTrial> process_noise = {};
  RobustCovariance robust;             ///< of the unknowns that do not drift, in the filter's state
  std::vector<EstimatedInput> inputs;  ///< excitations that were not measured
  /// From the whole record, where the settings ask for it and the filter did not fail; the monitored quantities are
  /// those of `result`.
  std::optional<SmoothedRecord> smoothed;
  std::vector<EstimatedInput> smoothed_inputs;
  Eigen::VectorXd robust_deviation;  ///< one per unknown [its unit]; NaN if it drifts, or after a failure
  /// What the record tells of the unknowns about one point; null: not looked at. Where the filter is too sure of one,
  /// the robust covariance and deviations are those of this information.
  std::shared_ptr<const UnknownInformation> information = {};
  /// How the estimates move with numbers that are held fixed, and what the record says of them; null: not looked at.
  std::shared_ptr<const FixedNumberStudy> fixed_numbers = {};
  /// What became of the numbers that the record asks to change; null where they were not looked at.
  std::shared_ptr<const FreedNumbers> freed = {};
  /// Each sensor predicted from all others, as a virtual one; null where that was not tried.
  std::shared_ptr<const HeldOutStudy> held_out_sensors = {};
  /// What the settings' known_to adds to each unknown [its unit]; empty where nothing is stated. The deviations of
  /// monitored quantities and inputs hold it, and innovations are those with the numbers as the record asks for within
  /// what is stated.
  Eigen::VectorXd considered_deviation = {};
  SecondThoughts second_thoughts = SecondThoughts::done;
  std::vector<std::string> left_out = {};     ///< searches that the settings' second_thoughts do not allow, in words
  double steps_left = StepBudget::unlimited;  ///< filter steps that they allow for what is still to come
  int reductions =
      0;  ///< repeated reductions of the finite elements at the estimated parameters, each with a run over the record
  std::optional<SimulationResult>
      open_loop;                      ///< the record again from the estimated parameters and initial state alone
  std::string open_loop_failure;      ///< in words, where that simulation failed; the members beside it are empty then
  Eigen::MatrixXd open_loop_sensors;  ///< sensors x samples
  std::vector<double> open_loop_nrmse;       ///< per sensor, about the channel's rest
  std::vector<double> open_loop_rest_error;  ///< last value against the channel's, per sensor

  /// Time from the record's start to the first sample that counts [s].
  [[nodiscard]] double judged_from() const { return static_cast<double>(settled) / measurements.sample_rate; }
  /// Notes a search that second_thoughts do not allow.
  void leave_out(std::string what);
  /// Whether the filter computed any sample: without one there is nothing to tell or to draw.
  [[nodiscard]] bool has_samples() const { return !result.failure || result.failure->computed > 0; }
  /// When and why the filter stopped, in words; empty if it ran to the end.
  [[nodiscard]] std::string failure() const;
};

/// Settings of an estimation that do not change its estimates.
struct RecordEstimateOptions {
  std::vector<OutputDescription> monitored = {};  ///< further quantities to estimate at every sample
  int deviation_stride = 1;                       ///< see EstimationOptions
  Progress progress = {};
  std::vector<std::string> updated = {};  ///< parameters that an updating found: they are not held fixed
  /// Called with the first answer, before the second thoughts. What its substeps bias stands in its intervals.
  std::function<void(const RecordEstimate&)> on_first_answer = {};
};

/// Finds the likelihood unknowns (estimate_likelihood_unknowns()), runs the filter over the corrected record with as
/// many substeps as the estimates need, and evaluates its result: consistency after settling, robust deviations, and,
/// if the initial state was estimated too, the simulation from the estimates alone (open loop).
RecordEstimate estimate_record(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                               const Record& record, const RecordEstimateOptions& options = {});

/// The same, the first answer first, and within what the settings' `second_thoughts` allow: more substeps, changes of
/// unknowns and other process noise (study_process_noise()), the last two unless the settings' `diagnose` is off. Fixed
/// numbers that the record asks to change are tried as unknowns (try_numbers()); with the settings'
/// FreeNumbers::automatic the estimate is that with those kept, and its `freed` holds the problem, of which `setup` is
/// then the filter's model. Bands hold what a finer step changes (RecordEstimation::widen_by_step()). Last, each sensor
/// is held out as a virtual one (study_held_out_sensors()). If linear unknowns end far from the values at which the
/// finite elements were reduced, reduces these at the estimates, replaces `setup`, and runs over the record again.
/// Throws InvalidInput if a reduction fails.
RecordEstimate estimate_record_thoroughly(const EstimationProblemPtr& problem, AugmentedModelSetup& setup,
                                          const Record& record, const RecordEstimateOptions& options = {});

/// One pass of an estimate's filter over its record again: its noise, outliers and samples that are held out, without
/// series of the states.
EstimationOptions rerun_options(FilterKind filter, const EstimationSettings& settings, const RecordEstimate& estimate);

/// The problem with the unknowns beginning at the estimates, within `breadth` of their deviations or what was stated
/// where that is less, and with the estimate's substeps, for one pass. Random walks keep their prior.
EstimationProblemPtr about_estimates(const EstimationProblem& problem, const RecordEstimate& estimate, double breadth);

/// The last estimates of the unknowns in the linear part of the filter's model.
Eigen::VectorXd linear_estimates(const RecordEstimate& estimate);

}  // namespace kalfem
