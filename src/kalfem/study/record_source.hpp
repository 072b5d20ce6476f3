// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/channel_calibration.hpp"
#include "kalfem/records/record_preparation.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

namespace description {
struct Case;
struct Sensor;
}  // namespace description

/// What the case knows of a sensor. Throws InvalidInput for a gain of 0 and an offset in another unit.
ChannelCalibration calibration_of(const std::string& name, const description::Sensor& sensor);

/// Reads the channels of the case's sensors, one row a sensor in their order, and prepares the record as the case asks.
/// Throws InvalidInput (missing file or channel, units that do not fit, samples that are not finite unless the case
/// skips them, an empty part, a channel without any number in it or with one value throughout).
PreparedRecord read_measured_record(const description::Case& given);

/// The channel of one sensor as its file holds it, in SI, neither calibrated nor prepared. Throws the same.
Record read_sensor_channel(const description::Case& given, const std::string& sensor);

/// Gives each channel of the measured record the unit and the noise of its sensor. Throws InvalidInput where per cent
/// of a channel that is 0 throughout are no noise.
void set_noise(Study& study);

/// The same for another record of the study's sensors.
void set_noise(const Study& study, Record& record);

/// Throws the same for a record with one channel a sensor; `channel` names one in the message.
void check_noise(const Study& study, const Record& record, const std::string& channel);

}  // namespace kalfem
