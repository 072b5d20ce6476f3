#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

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

/// The object "updating" of summary.json.
nlohmann::ordered_json updating_summary(const Study& study, const UpdatingOutcome& outcome);

}  // namespace kalfem
