// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Throws InvalidInput with every sensor that the record has no samples of.
void require_channels(const Record& record, const std::vector<SensorDescription>& sensors);

/// The record's channels of the sensors, with their noise. Throws as require_channels() does.
Record record_of_sensors(const Record& record, const std::vector<SensorDescription>& sensors);

}  // namespace kalfem
