// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/report/finished/finished_run.hpp"

namespace kalfem {

/// What one step identified: initial value, estimate, 95 % interval and from which deviation it comes, both
/// deviations, truth and difference from it. Readable units.
Table found_parameter_table(const FoundParameters& found);

/// A row for each point or sensor and a column for each quantity that one of them has.
Table found_error_table(const std::string& title, const std::string& first_column, const Named<NamedErrors>& errors);

/// Measured modes beside those of the model.
Table found_pair_table(const std::string& comparison, const std::vector<FoundPair>& pairs);

/// Seconds by step.
Table found_timing_table(const NamedErrors& timing);

/// The report of a finished run as the terminal showed it, from the numbers of its summary: parameters, consistency,
/// errors, validation, prediction, timing, files. The verdict stands in FinishedRun.
std::string console_report(const FinishedRun& run);

}  // namespace kalfem
