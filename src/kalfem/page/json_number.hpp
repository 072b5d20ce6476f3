// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

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
inline nlohmann::ordered_json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  auto list = nlohmann::ordered_json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

}  // namespace kalfem
