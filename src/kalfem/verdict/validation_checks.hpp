// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// Open-loop error of one sensor on data that the estimates were not found from. Errors and noise are relative to the
/// rms of the measured channel about its mean.
struct ValidatedSensor {
  std::string name;
  double error = 0.0;                 ///< NRMSE on the validation part
  double noise = 0.0;                 ///< stated noise there
  std::optional<double> own_error{};  ///< NRMSE on the part that is estimated from; nothing: there is no such record
  double own_noise = 0.0;             ///< stated noise on that part
};

/// Error of the motion itself, without the noise that no simulation can predict,
///     e = sqrt((error^2 - noise^2) / (1 - noise^2)),   0 below the noise.
/// Nothing if the noise is more than half of the channel's variance: such a channel says too little.
std::optional<double> motion_error(double error, double noise);

/// Reasons that a validation gives: a sensor is hardly better predicted than by no motion at all ("validation_error";
/// unusable where the prediction is much worse than that), or much worse than on the part that is estimated from
/// ("validation_worse").
std::vector<Reason> validation_reasons(const std::vector<ValidatedSensor>& sensors);

}  // namespace kalfem
