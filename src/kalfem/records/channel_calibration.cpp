// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_calibration.hpp"

#include "kalfem/records/clock_lag.hpp"

namespace kalfem {

void calibrate(Record& record, Eigen::Index j, const ChannelCalibration& calibration) {
  auto samples = record.values.row(j);
  const ClockLag lag{calibration.delay, calibration.drift, record.start};
  if (!lag.is_none()) samples = without_lag(record, j, lag).transpose();
  samples = (samples.array() - calibration.offset) / calibration.gain;
}

}  // namespace kalfem
