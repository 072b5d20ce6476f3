// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Wall time of every step of the run [s]: "load" without "reduce", "reduce", "modes", "simulate", ...
PhaseTimes step_times(const Study& study, const StudyResults& results);

/// How long each step took.
Table timing_table(const Study& study, const StudyResults& results);

/// What a run tells on request: the filters that were tried and how each ended, and how much time each step took.
std::string console_details(const Study& study, const StudyResults& results);

}  // namespace kalfem
