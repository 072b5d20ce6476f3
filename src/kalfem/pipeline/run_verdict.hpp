#pragma once

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/verdict/checks.hpp"

namespace kalfem {

/// The innovations of an estimation as its verdict sees them: after settling.
InnovationRecord innovations_of(const EstimationOutcome& outcome);

/// What the numbers of an estimation say about themselves, without the cause.
Verdict verdict_of(const EstimationOutcome& outcome);

/// What the numbers of a run say about themselves: the reasons of every step that ran, or why one of them failed.
Verdict verdict_of(const Study& study, const StudyResults& results);

}  // namespace kalfem
