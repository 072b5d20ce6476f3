// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Open-loop errors on the validation part, beside those on the part that is estimated from, and the noise.
Table validation_table(const ValidationOutcome& outcome);
/// "Validation: 2 s to 4 s of record.csv".
std::string validation_part_words(const ValidationPlan& plan);
/// The same, with how the simulation starts, or why there is none.
std::string validation_words(const Study& study, const ValidationOutcome& outcome);

}  // namespace kalfem
