// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/look_for_cause.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/diagnosis/fixed_number_reasons.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/verdict/reason_kinds.hpp"

namespace kalfem {

namespace {

bool has_a_cause(const Reason& reason) {
  const auto* kind = kind_of_reason(reason.code);
  return !kind || kind->has_a_cause;
}

/// Outliers that were found give a reason, and their samples count little already.
bool is_of_event(const Reason& reason, const RecordEstimate& estimate) {
  return reason.code == "outliers" && std::ranges::any_of(estimate.events, [&](const SensorEvent& event) {
           return event.kind == EventKind::outliers && event.channel == reason.subject;
         });
}

/// Of a sample interval in the trials of a diagnosis: mistakes are larger than what finer steps add.
constexpr int most_trial_substeps = 4;

/// Of the NIS over what is expected: no step alone makes innovations ten times too large.
constexpr double beyond_steps = 100.0;

/// Whether a trial could blame the model for what substeps do that have not settled.
bool may_be_of_the_step(const RecordEstimate& estimate) {
  const auto& found = estimate.consistency;
  return estimate.substeps.stopped && !(found.mean_nis > beyond_steps * found.expected_nis);
}

bool is_doubtful(const RecordEstimate& estimate) {
  const bool overstated_noise = estimate.consistency.mean_nis < 0.5 * estimate.consistency.expected_nis;
  const bool jumps = estimate.jump && estimate.jump->explains;
  if (overstated_noise || jumps || !fixed_number_reasons(estimate).empty()) return false;
  return std::ranges::any_of(verdict_of(estimate).reasons(), [&](const Reason& reason) {
    return has_a_cause(reason) && !is_of_event(reason, estimate);
  });
}

/// A mistake that explains all takes the place of a change that does not.
void forget_change(RecordEstimate& estimate) {
  estimate.jump.reset();
  std::erase_if(estimate.events, [](const SensorEvent& event) { return event.is_change(); });
}

/// The NIS of every sample that the filter computed.
Eigen::VectorXd computed_nis(const EstimationResult& result) {
  return result.failure ? result.nis.head(std::min(result.failure->computed, result.nis.size())) : result.nis;
}

}  // namespace

std::optional<Diagnosis> look_for_cause(const EstimationProblem& problem, const StructureParts& parts,
                                        const Record& record, RecordEstimate& estimate,
                                        const std::vector<std::string>& updated) {
  if (!problem.settings.diagnose) return std::nullopt;
  // An unknown input makes up for most mistakes, and its assumed process for others: trials could not tell them apart.
  if (!problem.settings.unknown_inputs.empty()) return std::nullopt;
  if (!estimate.result.failure && !is_doubtful(estimate)) return std::nullopt;
  std::optional<Diagnosis> diagnosis;
  if (!may_be_of_the_step(estimate)) {
    const auto& likelihood = estimate.likelihood;
    auto as_run = std::make_shared<EstimationProblem>(likelihood ? *likelihood->corrected.problem : problem);
    as_run->settings.substeps = std::min(most_trial_substeps, estimate.augmented_model->options().substeps);
    std::shared_ptr<const UncorrectedRun> uncorrected;
    if (likelihood)
      uncorrected = std::make_shared<UncorrectedRun>(
          UncorrectedRun{std::make_shared<EstimationProblem>(problem), parts, record, estimate.events});
    diagnosis = diagnose(
        {.problem = std::move(as_run),
         .parts = parts,
         .record = without(likelihood ? likelihood->corrected.record : record, estimate.events),
         .options = {.unscented = problem.settings.unscented, .adaptive_noise = problem.settings.adaptive_noise},
         .nis = computed_nis(estimate.result),
         .steps = estimate.steps_left,
         .updated = updated,
         .uncorrected = std::move(uncorrected)});
  }
  if (diagnosis && estimate.jump && !estimate.jump->explains && diagnosis->explains_all()) forget_change(estimate);
  if (!diagnosis)
    estimate.leave_out("the mistake behind the contradiction");
  else if (std::isfinite(estimate.steps_left)) {
    if (!diagnosis->one_explains_all()) estimate.leave_out("a second mistake beside the likeliest one");
    estimate.steps_left = 0.0;
  }
  return diagnosis;
}

}  // namespace kalfem
