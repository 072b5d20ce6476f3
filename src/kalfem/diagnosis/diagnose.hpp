// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/diagnosis/hypothesis.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

constexpr double diagnosis_trials = 100.0;  ///< runs over a part of the record that a diagnosis takes, about

/// Tests the mistakes that an engineer would look for, one at a time: the run is repeated with each undone, and the one
/// under which the record is most likely is the cause. Numbers such as gains and delays are first guessed from what
/// the other sensors predict, then searched by likelihood.
/// Long or costly runs are tested on the first part of their record. Throws InvalidInput as make_filter_run() does.
Diagnosis diagnose(const DiagnosisInput& input);

/// The cause as a reason of that state, with what else would explain as much.
std::vector<Reason> reasons_of(const Diagnosis& diagnosis, VerdictState state);

}  // namespace kalfem
