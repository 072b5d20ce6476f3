// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// The excitations that the filter does not know. Problems go to `issues` with their place, those of steps of the case
/// among them that need every excitation.
std::vector<UnknownInput> unknown_inputs_of(const CaseStudy& study, IssueList& issues);

/// Refuses unknown excitations in a case that does not estimate, and those without a signal in one that simulates.
void check_unknown_excitations(const description::Case& given, IssueList& issues);

}  // namespace kalfem
