// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/steps/run_study.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

struct EstimationOutcome;

/// What the numbers of a run say about themselves: the reasons of every step that ran, or why one of them failed.
Verdict verdict_of(const Study& study, const StudyResults& results);

/// The case with the values that the run found. Nothing if it found none, or if its numbers are not usable.
std::optional<IdentifiedCase> identified_case_of(const Study& study, const StudyResults& results);

/// Sets the verdict of a run and its identified case. Suspicions become warnings, and so does what the second thoughts
/// left out.
void judge(const Study& study, StudyResults& results);

/// Keeps the first answer, should the run be stopped, and hands it over, judged.
void tell_first(const Study& study, const RunOptions& options, EstimationOutcome first, StudyResults& results);

/// The run was asked to stop: what it has finished stays.
void mark_interrupted(StudyResults& results);

}  // namespace kalfem
