// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/diagnosis/hypothesis.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// Tests the mistakes that an engineer would look for, one at a time: the run is repeated with each undone, and the one
/// under which the record is most likely is the cause. Where it does not explain all, a second one is looked for beside
/// each of the likeliest, unless `input.steps` limits the search.
/// Long or costly runs are tested on the first part of their record; within `input.steps` the mistakes are raced on
/// parts of growing length. Nothing where so few steps tell nothing. Throws InvalidInput as make_filter_run() does.
std::optional<Diagnosis> diagnose(const DiagnosisInput& input);

/// The causes as reasons of that state, with what else would explain as much.
std::vector<Reason> reasons_of(const Diagnosis& diagnosis, VerdictState state);

}  // namespace kalfem
