// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// What the estimates are with other process noise, for summary.json: an array of one object a factor.
nlohmann::ordered_json process_noise_summary(const RecordEstimate& estimate);
/// The same as a table: a row each unknown, a column each factor.
Table process_noise_table(const RecordEstimate& estimate);
Section process_noise_section(const RecordEstimate& estimate);

}  // namespace kalfem
