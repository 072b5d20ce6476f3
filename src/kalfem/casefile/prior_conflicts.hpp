#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// A sentence for each unknown whose estimate ended more than four prior standard deviations from its first guess: the
/// prior contradicts the record. The filter linearises about its estimate, so that an estimate that travels so far may
/// be wrong by many of its stated deviations; where the mean NIS is more than a fifth off as well, the sentence says
/// that it cannot be trusted. Unknowns that are allowed to drift are left out.
std::vector<std::string> prior_conflicts(const EstimationStage& stage);

}  // namespace kalfem
