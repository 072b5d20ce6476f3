// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Checks that the augmented model can run over the record. An initial state from the record needs a displacement
/// sensor and its first samples; a channel that drives an interface needs all of its samples. Problems go to `issues`.
void check_augmented_model(const CaseStudy& study, IssueList& issues);

/// Makes the filter of the case's `estimate` on the first samples. Throws InvalidInput if its options or its model are
/// not usable.
void check_filter(const CaseStudy& study);

/// Settings of `estimate` that are allowed but are probably a mistake, one sentence each.
std::vector<std::string> doubtful_estimation(const CaseStudy& study);

/// Checks that estimated motion can drive the substructure as `model` holds it. Throws InvalidInput if it has no
/// boundary or no interior, if its interior can move freely, or if the augmented model does not contain a point of its
/// boundary.
void check_driven(const Study& study, const CoupledModel& model, const Name& substructure);

}  // namespace kalfem
