// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// The noise that a filter found along the record, for summary.json: of each sensor and of the process what was stated,
/// the last value and the range after settling. `estimate` has a course of its noise.
nlohmann::ordered_json adaptive_noise_summary(const RecordEstimate& estimate);
/// A line each for the terminal.
std::string adaptive_noise_words(const RecordEstimate& estimate);
/// Each over time, beside what was stated.
Section adaptive_noise_section(const RecordEstimate& estimate);

}  // namespace kalfem
