// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/identification/frequency_course.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Natural frequencies over the record for summary.json: each with its range and its last value.
nlohmann::ordered_json frequencies_summary(const FrequencyCourse& course);
/// The same as a table.
Table frequencies_table(const FrequencyCourse& course);
/// The table, and each frequency over time with its 95 % band.
Section frequencies_section(const FrequencyCourse& course);

}  // namespace kalfem
