// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/compared.hpp"

#include "kalfem/steps/correlation/outcome.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/steps/validation/outcome.hpp"

namespace kalfem {

bool has_verdict(const StudyResults& results) {
  return results.has<EstimationOutcome>() || results.has<UpdatingOutcome>() || results.has<ValidationOutcome>() ||
         results.has<InferenceOutcome>() || !results.complete() || !results.verdict.reasons().empty();
}

std::string why_no_verdict(bool correlated) {
  return correlated ? "the model was compared with measurements, but nothing was updated"
                    : "nothing was compared with measurements";
}

std::string why_no_verdict(const StudyResults& results) { return why_no_verdict(results.has<CorrelationOutcome>()); }

}  // namespace kalfem
