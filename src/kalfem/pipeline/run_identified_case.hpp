// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// The case with the values that the run found. Nothing if it found none, or if its numbers are not usable.
std::optional<IdentifiedCase> identified_case_of(const Study& study, const StudyResults& results);

}  // namespace kalfem
