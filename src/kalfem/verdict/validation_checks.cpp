// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/validation_checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kalfem {

namespace {

constexpr double poor = 0.9;  ///< hardly better than no motion at all, which has an error of 1
/// Two motions of the same size without any common phase differ by 1.41 of it; more than that has another size too.
constexpr double senseless = 1.5;
constexpr double worse = 2.0;       ///< times the error on the estimation's own part ...
constexpr double noticeable = 0.2;  ///< ... and at least this much

Reason poor_prediction(const ValidatedSensor& sensor, double error) {
  return {
      "validation_error",
      sensor.name,
      fmt::format("on data that the estimates were not found from, the simulation of '{}' has an error of {:.2g} of "
                  "its motion (NRMSE {:.2g}, its noise {:.2g})",
                  sensor.name, error, sensor.error, sensor.noise),
      "the estimates do not predict the structure: look for a wrong law, a missing part or a wrong input, and check "
      "that both records show the same structure",
      error >= senseless ? VerdictState::unusable : VerdictState::suspicious,
      error};
}

Reason worse_prediction(const ValidatedSensor& sensor, double error) {
  return {"validation_worse",
          sensor.name,
          fmt::format("the simulation of '{}' has an NRMSE of {:.2g} on the validation part, but of {:.2g} on the part "
                      "that is estimated from",
                      sensor.name, sensor.error, *sensor.own_error),
          "the estimates fit one record only: estimate fewer parameters or from a longer record, and check that the "
          "structure and the size of its motion are the same",
          VerdictState::suspicious,
          error};
}

}  // namespace

std::optional<double> motion_error(double error, double noise) {
  const double motion = 1.0 - noise * noise;
  if (!(motion > 0.5)) return std::nullopt;
  return std::sqrt(std::max(0.0, error * error - noise * noise) / motion);
}

std::vector<Reason> validation_reasons(const std::vector<ValidatedSensor>& sensors) {
  std::vector<Reason> reasons;
  for (const auto& sensor : sensors) {
    const auto error = motion_error(sensor.error, sensor.noise);
    const auto own = sensor.own_error ? motion_error(*sensor.own_error, sensor.own_noise) : std::nullopt;
    if (error && *error >= poor) reasons.push_back(poor_prediction(sensor, *error));
    if (error && own && *error >= noticeable && *error > worse * *own)
      reasons.push_back(worse_prediction(sensor, *error));
  }
  return reasons;
}

}  // namespace kalfem
