#pragma once

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// Natural frequencies of the case's modifications, of the updated structure where there was an updating. Throws
/// InvalidInput for parameters that the substructure does not have.
std::vector<ModificationResult> predict_modifications(const Study& study, const std::optional<UpdatingStage>& updating);

/// Problems of the modifications' names and values.
void check_modifications(const Study& study, IssueList& issues);

}  // namespace kalfem
