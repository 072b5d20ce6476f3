// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// What the numbers of a run say about themselves: the reasons of every step that ran, or why one of them failed.
Verdict verdict_of(const Study& study, const StudyResults& results);

}  // namespace kalfem
