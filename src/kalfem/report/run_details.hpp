#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// How long each step took.
Table timing_table(const Study& study, const StudyResults& results);

/// What a run tells on request: the filters that were tried and how each ended, and how much time each step took.
std::string console_details(const Study& study, const StudyResults& results);

}  // namespace kalfem
