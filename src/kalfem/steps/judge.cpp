// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/steps/estimation/outcome.hpp"

namespace kalfem {

void judge(const Study& study, StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  if (estimation && estimation->second_thoughts == SecondThoughts::stopped && !results.interrupted)
    results.warnings.push_back(fmt::format("not looked for, as second_thoughts: {:g} allow no more filter steps: {}",
                                           study.problem->settings.second_thoughts,
                                           fmt::join(estimation->left_out, "; ")));
  results.verdict = verdict_of(study, results);
  for (const auto& reason : results.verdict.reasons())
    if (reason.state == VerdictState::suspicious) results.warnings.push_back(sentence_of(reason));
  results.identified = identified_case_of(study, results);
  if (estimation && estimation->freed && estimation->freed->problem && !estimation->freed->taken)
    results.proposed = propose(study, estimation->freed->kept());
  else if (estimation && estimation->held_out_sensors && estimation->held_out_sensors->proposes())
    results.proposed = propose_adapted_process(study, estimation->held_out_sensors->adapted->density);
}

void tell_first(const Study& study, const RunOptions& options, EstimationOutcome first, StudyResults& results) {
  const auto& estimation = results.put(std::move(first));
  if (!options.on_first_answer) return;
  const auto warnings = results.warnings;
  results.failure = estimation.failure();
  judge(study, results);
  options.on_first_answer(results);
  results.warnings = warnings;
  results.failure.clear();
}

void mark_interrupted(StudyResults& results) {
  results.interrupted = true;
  results.failure = "the run was stopped before its end";
  auto* estimation = results.find<EstimationOutcome>();
  if (estimation && estimation->second_thoughts == SecondThoughts::pending)
    estimation->second_thoughts = SecondThoughts::stopped;
}

std::string StudyResults::why_unusable() const {
  const auto reasons = verdict.reasons();
  if (reasons.empty() || reasons.front().state != VerdictState::unusable) return failure;
  return sentence_of(reasons.front());
}

}  // namespace kalfem
