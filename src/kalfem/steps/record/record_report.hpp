// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Where a sensor of a free response rests, in the file's coordinates.
struct RestFound {
  std::string sensor, unit;
  double position = 0.0;            ///< [unit]
  std::optional<double> deviation;  ///< standard deviation of an estimated one [unit]
};

/// Rest positions that were found in the record, or with the estimates where it ends before the rest.
std::vector<RestFound> rest_positions(const Study& study, const StudyResults& results);

/// Part of the file, samples, how it was prepared, release and rest; for summary.json.
nlohmann::ordered_json record_summary(const Study& study, const StudyResults& results);

/// The same in words, a line each; empty where the case reads no record.
std::string record_words(const Study& study, const StudyResults& results);

}  // namespace kalfem
