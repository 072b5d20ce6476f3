// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/correlation/outcome.hpp"

namespace kalfem {

/// Measured modes beside those of the model.
Table correlated_mode_table(const Correlation& correlation);
/// Sensors by their COMAC, the lowest first, at most so many.
Table correlated_sensor_table(const Correlation& correlation, std::size_t most);
/// "a7 is turned: it measures against its direction; mended, the mean MAC rises from 0.871 to 0.994"
std::string words_of(const SetupMistake& mistake);

/// The object "correlation" of summary.json, by comparison.
nlohmann::ordered_json correlation_summary(const CorrelationOutcome& outcome);
/// As a person reads it on a terminal.
std::string console_correlation(const CorrelationOutcome& outcome);
/// The page: tables, MAC, AutoMAC and orthogonality.
Section correlation_section(const CorrelationOutcome& outcome);

}  // namespace kalfem
