// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/frequency_response/outcome.hpp"

namespace kalfem {

/// The object "frequency_response" of summary.json: the band, the models, and each response with its peaks and with how
/// far the reduced model is from the full one; all SI.
nlohmann::ordered_json frequency_response_summary(const FrequencyResponseOutcome& outcome);

/// "3 frequency responses from 1 to 150 Hz; the reduced model differs by at most 0.03 % of the peak at resonances."
std::string frequency_response_answer(const FrequencyResponseOutcome& outcome);

/// As a person reads it on a terminal.
std::string console_frequency_responses(const FrequencyResponseOutcome& outcome);

/// The page: the peaks, the differences, and magnitude and phase of each response.
Section frequency_response_section(const FrequencyResponseOutcome& outcome);

/// For each input, quantity and model frf_<model>_<quantity>_<input>.csv with the outputs as columns, see
/// write_frf_table().
void write_frequency_responses(const std::filesystem::path& folder, const FrequencyResponseOutcome& outcome);

}  // namespace kalfem
