// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/report/sensor_course.hpp"

namespace kalfem {

/// The agreement of a sensor over time as a strip of bars: low and green inside the 95 % band of chance, higher and
/// amber, full and red outside the 99.9 % band. A mark at the worst window leads to the chart `chart_id` at that time.
std::string agreement_strip_svg(const SensorCourse& sensor, const std::string& chart_id);

}  // namespace kalfem
