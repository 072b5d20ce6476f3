// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What each step found, as a person reads it on a terminal.
std::string console_report(const Study& study, const StudyResults& results);

/// Wall time of every step of the run [s]: "load" without "reduce", "reduce", "modes", "simulate", ...
PhaseTimes step_times(const Study& study, const StudyResults& results);

/// How long each step took.
Table timing_table(const Study& study, const StudyResults& results);

/// What a run tells on request: the filters that were tried and how each ended, and how much time each step took.
std::string console_details(const Study& study, const StudyResults& results);

}  // namespace kalfem
