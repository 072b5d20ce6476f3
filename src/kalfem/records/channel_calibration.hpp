// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/records/record.hpp"

namespace kalfem {

/// What is known of a sensor: it records  gain signal + offset  by a clock of its own, see ClockLag. The drift counts
/// from the record's first sample.
struct ChannelCalibration {
  double gain = 1.0;    ///< negative where the sensor looks the other way; not 0
  double offset = 0.0;  ///< [unit of the channel]
  double delay = 0.0;   ///< [s]
  double drift = 0.0;   ///< [s/s]

  [[nodiscard]] bool changes_anything() const { return gain != 1.0 || offset != 0.0 || delay != 0.0 || drift != 0.0; }
};

/// Puts the signal in the place of what was recorded in row j. Samples of which a clock that is late tells nothing, at
/// an end, are missing (fractional_shift.hpp).
void calibrate(Record& record, Eigen::Index j, const ChannelCalibration& calibration);

}  // namespace kalfem
