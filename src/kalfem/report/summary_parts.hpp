// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// A number of summary.json: null where it is unknown or not finite.
inline nlohmann::ordered_json number(double value) {
  using Json = nlohmann::ordered_json;
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
inline nlohmann::ordered_json number(const std::optional<double>& value) {
  return value ? number(*value) : nlohmann::ordered_json(nullptr);
}
/// A list of such numbers.
nlohmann::ordered_json numbers(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Takes the times that were measured out of summary.json, or a part of it: what stays is the same for the same run.
void drop_times(nlohmann::ordered_json& json);

/// The object "updating" of summary.json.
nlohmann::ordered_json updating_summary(const Study& study, const UpdatingOutcome& outcome);

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
