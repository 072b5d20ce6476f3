#pragma once

#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Estimates that contradict their priors, a sentence each.
struct PriorConflicts {
  std::vector<std::string> warnings;  ///< the estimate may hold all the same
  std::vector<std::string> failures;  ///< it cannot be trusted
};

/// The unknowns whose estimates ended more than four prior standard deviations from their first guesses. The filter
/// linearises about its estimate, so that an estimate that travels so far may be wrong by many of its stated
/// deviations: it cannot be trusted where the mean NIS is more than a fifth above the expected one as well. Unknowns
/// that are allowed to drift are left out.
PriorConflicts prior_conflicts(const EstimationOutcome& outcome);

}  // namespace kalfem
