// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/judge.hpp"

#include <limits>

#include "kalfem/diagnosis/diagnose.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/diagnosis/judge_updating.hpp"
#include "kalfem/diagnosis/judge_validation.hpp"
#include "kalfem/steps/correlation/outcome.hpp"
#include "kalfem/steps/correlation/report.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

namespace {

std::vector<Reason> reasons_of(const std::vector<UpdatingParameter>& parameters, const UpdatingOutcome& outcome) {
  EndOfUpdating end{.parameters = parameters,
                    .values = outcome.values,
                    .statistics = outcome.statistics,
                    .robust = outcome.robust,
                    .converged = outcome.converged,
                    .termination = outcome.termination};
  for (const auto& each : outcome.comparisons)
    end.comparisons.push_back({each.name, each.size, each.rms_final, each.has_bounds, each.modes_final});
  return updating_reasons(end);
}

/// Mistakes of a modal test's set-up stand before the misfit that follows from them.
std::vector<Reason> reasons_of(const CorrelationOutcome& outcome) {
  std::vector<Reason> reasons;
  for (const auto& each : outcome.comparisons)
    for (const auto& mistake : each.correlation.mistakes)
      reasons.push_back({"setup_mistake", each.name, words_of(mistake),
                         "look at the set-up, then correct `points` of the comparison", VerdictState::suspicious,
                         std::numeric_limits<double>::infinity()});
  for (const auto& each : outcome.responses)
    for (const auto& turned : turned_ones(each.responses))
      reasons.push_back({"setup_mistake", each.name, turned,
                         "look at the set-up, then change the sign of the column, or of the input's",
                         VerdictState::suspicious, std::numeric_limits<double>::infinity()});
  return reasons;
}

/// Of every step that ran. A step that failed is the reason, and what it left is not judged: it would only say again
/// that there is nothing.
Verdict verdict_of_steps(const Study& study, const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  if (estimation && estimation->result.failure) return verdict_of(*estimation);
  Verdict verdict;
  if (!results.complete()) {
    verdict.add({"failed", "", results.failure, "", VerdictState::unusable, unusable_widening});
    return verdict;
  }
  if (const auto* updating = results.find<UpdatingOutcome>())
    verdict.add(reasons_of(study.updating->parameters, *updating));
  if (const auto* correlation = results.find<CorrelationOutcome>()) verdict.add(reasons_of(*correlation));
  if (estimation) verdict.add(verdict_of(*estimation).reasons());
  return verdict;
}

}  // namespace

Verdict verdict_of(const Study& study, const StudyResults& results) {
  Verdict verdict = verdict_of_steps(study, results);
  if (const auto* validation = results.find<ValidationOutcome>()) verdict.add(reasons_of(*validation));
  if (const auto* estimation = results.find<EstimationOutcome>(); estimation && estimation->diagnosis)
    verdict.add(reasons_of(*estimation->diagnosis, verdict.state()));
  return verdict;
}

}  // namespace kalfem
