// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/identification/fixed_numbers.hpp"

namespace kalfem {

/// What a case states of fixed numbers, in SI. Problems go to `issues` with their place.
std::vector<KnownTo> known_to_of(const Named<description::Value>& given, const std::vector<FixedNumber>& numbers,
                                 IssueList& issues);

/// What a case states of the numbers that its estimation holds fixed, in SI. Problems go to `issues` with their place.
std::vector<KnownTo> known_to_of(const Named<description::Value>& given, const EstimationProblem& problem,
                                 const StructureParts& parts, const AugmentedModelSetup& setup, IssueList& issues);

}  // namespace kalfem
