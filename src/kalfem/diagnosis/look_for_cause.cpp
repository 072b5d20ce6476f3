// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/look_for_cause.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "kalfem/diagnosis/judge_estimation.hpp"

namespace kalfem {

namespace {

/// Whether a mistake may be behind a reason. None is where a sensor's fault was found and left out, none is where the
/// record holds little about an unknown, nor where noise is stated too large, which the reason says itself.
bool has_a_cause(const Reason& reason) {
  static const std::set<std::string> by_themselves{
      "not_identified",  "correlated",  "combination",  "noise_too_large",  "at_bound",
      "step_too_coarse", "sensor_dead", "sensor_stuck", "sensor_saturated", "process_noise_decides"};
  return !by_themselves.contains(reason.code);
}

/// Outliers that were found give a reason, and their samples count little already.
bool is_of_event(const Reason& reason, const RecordEstimate& estimate) {
  return reason.code == "outliers" && std::ranges::any_of(estimate.events, [&](const SensorEvent& event) {
           return event.kind == EventKind::outliers && event.channel == reason.subject;
         });
}

/// Of a sample interval in the trials of a diagnosis: mistakes are larger than what finer steps add.
constexpr int most_trial_substeps = 8;
constexpr double fewest_samples = 500.0;  ///< for each trial: with fewer, coarser steps or none

/// As many as the estimate's, where the steps that are left allow it; 0: they allow no diagnosis.
int trial_substeps(const RecordEstimate& estimate) {
  const double allowed = estimate.steps_left / (diagnosis_trials * fewest_samples);
  int substeps = std::min(most_trial_substeps, estimate.augmented_model->options().substeps);
  while (substeps > allowed) substeps /= 2;
  return substeps;
}

bool is_doubtful(const RecordEstimate& estimate) {
  const bool overstated_noise = estimate.consistency.mean_nis < 0.5 * estimate.consistency.expected_nis;
  const bool explained = estimate.jump && estimate.jump->explains;
  return !overstated_noise && !explained &&
         std::ranges::any_of(verdict_of(estimate).reasons(), [&](const Reason& reason) {
           return has_a_cause(reason) && !is_of_event(reason, estimate);
         });
}

/// The NIS of every sample that the filter computed.
Eigen::VectorXd computed_nis(const EstimationResult& result) {
  return result.failure ? result.nis.head(std::min(result.failure->computed, result.nis.size())) : result.nis;
}

}  // namespace

std::optional<Diagnosis> look_for_cause(const EstimationProblem& problem, const StructureParts& parts,
                                        const Record& record, RecordEstimate& estimate) {
  if (!problem.settings.diagnose) return std::nullopt;
  // An unknown input makes up for most mistakes, and its assumed process for others: trials could not tell them apart.
  if (!problem.settings.unknown_inputs.empty()) return std::nullopt;
  if (!estimate.result.failure && !is_doubtful(estimate)) return std::nullopt;
  // Where substeps have not settled, the contradiction may be theirs, and a trial would blame the model for it.
  const int substeps = estimate.substeps.stopped ? 0 : trial_substeps(estimate);
  if (substeps == 0) {
    estimate.leave_out("the mistake behind the contradiction");
    return std::nullopt;
  }
  const double left_after = std::isfinite(estimate.steps_left) ? 0.0 : estimate.steps_left;
  const auto& likelihood = estimate.likelihood;
  auto as_run = std::make_shared<EstimationProblem>(likelihood ? *likelihood->corrected.problem : problem);
  as_run->settings.substeps = substeps;
  return diagnose(
      {.problem = std::move(as_run),
       .parts = parts,
       .record = without(likelihood ? likelihood->corrected.record : record, estimate.events),
       .options = {.unscented = problem.settings.unscented, .adaptive_noise = problem.settings.adaptive_noise},
       .nis = computed_nis(estimate.result),
       .samples = std::exchange(estimate.steps_left, left_after) / (diagnosis_trials * substeps)});
}

}  // namespace kalfem
