// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/identification/fixed_number_study.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/screening.hpp"

namespace kalfem {

/// As the problem states it, or as the innovations along the record show it.
enum class NoiseOfSensors { stated, as_recorded };

/// One estimation from a record, part by part; estimate() holds what is known so far:
///
/// 1. answer(): the likelihood unknowns, and the filter over the record without the samples of faulty sensors. Where
/// the
///    run does not tell itself that its substeps leave little in the estimates, one with half of them does. Where the
///    first samples alone say that the structure moves and the run contradicts itself, it is run from rest, too.
/// 2. repeat_from_estimates(): a run that contradicts itself again from its own estimates, as a filter that
///    linearises about a first guess far off learns wrongly from the first samples, and never forgets.
/// 3. settle_substeps(): as many more substeps as that bias asks for.
/// 4. confirm_by_second_pass(): where the record knows an unknown far better than its prior.
/// 5. kalfem::move_within_stated(): where the run contradicts itself, numbers that are known to some deviation stand
///    where the record has them.
/// 6. look_for_jump(): an unknown that is not constant. Within a limited budget it comes before more substeps where the
///    estimates change along the record: these substeps would settle a compromise.
///
/// Each search behind the answer ends before a run that the budget does not allow, and is then among what was left out.
class RecordEstimation {
public:
  RecordEstimation(EstimationProblemPtr problem, AugmentedModelSetup setup, Record record,
                   const RecordEstimateOptions& options);

  void answer();
  void repeat_from_estimates(StepBudget& budget);
  void settle_substeps(StepBudget& budget);
  void confirm_by_second_pass(StepBudget& budget);
  void look_for_jump(StepBudget& budget);
  /// Whether the estimates change along the record by more than what substeps leave in them.
  [[nodiscard]] bool shows_a_change() const;
  /// Bands of monitored quantities hold what a step four times as fine changes in them, with the run's gains.
  void widen_by_step(StepBudget& budget);
  /// They hold what the robust deviations of the unknowns have beyond the filter's.
  void widen_by_scores(StepBudget& budget);
  void study_process_noise(StepBudget& budget);
  void study_fixed_numbers(StepBudget& budget);
  /// Robust deviations hold what the record tells of the unknowns about one point; see information_at_estimates().
  void confirm_information(StepBudget& budget);
  /// Fixed numbers that the record asks to change, as unknowns: see kalfem::try_numbers().
  [[nodiscard]] NumberTrials try_numbers(StepBudget& budget);
  /// Sensors as virtual ones, in a run whose innovations agree with its model and that estimates more than they see.
  void hold_out_sensors(StepBudget& budget);

  /// The first answer with fixed numbers at `changed`, and with as many substeps as this one. Nothing where they make
  /// no structure, or the filter stops.
  [[nodiscard]] std::optional<RecordEstimation> with_numbers(const ChangedNumbers& changed, NoiseOfSensors noise) const;
  /// Changes of the stated numbers of the structure at which a filter ends that has the most telling of them as
  /// unknowns too; nothing where it stops.
  [[nodiscard]] std::optional<Eigen::VectorXd> learnt_numbers(const FixedNumberStudy& study) const;
  /// What the record says of the fixed numbers, about where this estimation stands; see kalfem::study_fixed_numbers().
  [[nodiscard]] std::optional<FixedNumberResult> study_numbers(StepBudget& budget) const;
  /// ln L of the recorded samples that are judged.
  [[nodiscard]] double log_likelihood() const;

  [[nodiscard]] RecordEstimate& estimate() { return estimate_; }
  [[nodiscard]] const RecordEstimate& estimate() const { return estimate_; }
  [[nodiscard]] double steps() const { return screening_->steps() + other_steps_; }  ///< filter steps so far

private:
  void correct();
  /// What is estimated, before gains, delays and noise are found.
  struct Given {
    EstimationProblemPtr problem;
    AugmentedModelSetup setup;
    Record record;
  };
  void run_first();
  void try_rest(FilteredRecord& filtered, int substeps);
  void pass_again(int passes, bool with_start);
  void evaluate(FilteredRecord filtered, SubstepChoice substeps);
  void add_event_of_change();
  void take_considered(const ConsideredNumbers& considered);
  void widen_monitored(const Eigen::MatrixXd& filtered, const Eigen::MatrixXd& smoothed);
  [[nodiscard]] FilterRun run_with(int substeps) const;
  [[nodiscard]] std::optional<Eigen::MatrixXd> monitored_with(int substeps) const;

  std::shared_ptr<const Given> given_;
  EstimationProblemPtr problem_;  ///< with gains, delays and noise at their likeliest, once these are found
  AugmentedModelSetup setup_;
  Record record_;
  RecordEstimateOptions options_;
  std::optional<LikelihoodEstimate> likelihood_;
  std::optional<Screening> screening_;
  std::optional<FilterRun> run_;  ///< of the estimate
  double other_steps_ = 0.0;      ///< beside those of the screening
  bool looked_for_change_ = false;
  ChangedNumbers changed_ = {};        ///< in the problem
  Eigen::VectorXd log_jacobian_ = {};  ///< of the record that they correct
  RecordEstimate estimate_;
};

/// Where an estimation contradicts itself, or an unknown changes, with the numbers that it holds fixed, and some of
/// them are known to a deviation only, these numbers c are moved to where the record, and what is stated of them, have
/// them:
///
/// the maximum over c of ln L(c) - c^T S^-1 c / 2, S the stated variances, the unknowns estimated at each c, by
/// Gauss-Newton, c <- (I + S^-1)^-1 (g + I c), with the score g and the information I of study_fixed_numbers(), the
/// step halved where the maximum is not approached. The first runs take what wrong numbers do for noise of the sensors:
/// such a filter is not misled by them. Where no step leads to numbers that are likely together, a filter that has them
/// as unknowns gives another start, and the higher maximum counts.
///
/// The estimation is replaced by the one there if its innovations no longer contradict the model; otherwise the stated
/// numbers are not what is wrong, and it stays. Whether it is replaced.
bool move_within_stated(RecordEstimation& estimation);

}  // namespace kalfem
