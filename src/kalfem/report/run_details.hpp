#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// What a run tells on request: the filters that were tried and how each ended, and how much time each step took.
std::string console_details(const Study& study, const StudyResults& results);

}  // namespace kalfem
