// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/study/inference_plan.hpp"

namespace kalfem {

/// The studies of infer.compare_laws: the same case with each law in the connector, its unknown parameters in place of
/// the connector's own ones, with the priors that the comparison gives them. Other unknowns keep their priors. Problems
/// go to `issues` with their place.
void add_law_alternatives(const CaseStudy& study, InferencePlan& plan, IssueList& issues);

/// The studies of estimate.alternatives: likewise, for an estimation each.
std::vector<LawAlternative> estimated_alternatives(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
