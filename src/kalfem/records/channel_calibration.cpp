// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_calibration.hpp"

#include "kalfem/records/fractional_shift.hpp"

namespace kalfem {

void calibrate(Record& record, Eigen::Index j, const ChannelCalibration& calibration) {
  auto samples = record.values.row(j);
  if (calibration.delay != 0.0)
    samples = shifted(samples.transpose(), calibration.delay * record.sample_rate).transpose();
  samples = (samples.array() - calibration.offset) / calibration.gain;
}

}  // namespace kalfem
