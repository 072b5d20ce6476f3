// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace kalfem {

/// A sensor that the filter predicted from all others: a virtual sensor whose truth is known.
struct HeldOutSensor {
  std::string name, unit;
  Eigen::Index samples = 0;       ///< compared
  double inside = 0.0;            ///< share of them within their 95 % band, which holds the sensor's noise
  double motion_deviation = 0.0;  ///< the band's standard deviation without that noise, root mean square [unit]
  double noise = 0.0;             ///< standard deviation [unit]
  /// Errors of the prediction: motion_errors(), in `limits` above which they contradict the band.
  double followed = 0.0, in_band = 0.0;
  /// Share of its motion, without noise, that the band holds if the errors found above the noise are normal; .95 where
  /// they do not contradict it.
  double motion_inside = 0.95;

  [[nodiscard]] bool holds() const { return followed <= 1.0 && in_band <= 1.0; }
};

/// The filter with process noise that it adapts, beside the one without.
struct AdaptedProcessTrial {
  double density = 0.0;  ///< where it starts, of every degree of freedom [m/s^2/sqrt(Hz)]
  double gain = 0.0;     ///< rise of ln L of the record
  std::vector<HeldOutSensor> sensors = {};
  bool mends = false;  ///< the bands of all of them hold, and the record is far likelier
};

}  // namespace kalfem
