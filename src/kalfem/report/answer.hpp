// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The first sentences of the page: what was found, from how many sensors, how sure that is, and what to do next.
std::string answer(const Study& study, const StudyResults& results);

}  // namespace kalfem
