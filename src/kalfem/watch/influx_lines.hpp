// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/watch/watcher.hpp"

namespace kalfem {

/// A line of a Watcher as lines of InfluxDB's line protocol, each with a line break, times in nanoseconds:
///     kalfem,case=tower condition="consistent",samples=500i,late=0i,bad_lines=0i 1250000000
///     kalfem_parameter,case=tower,parameter=strut.k3,unit=N/m^3 estimate=3e6,std=2e4 1250000000
///     kalfem_output, kalfem_alarm, kalfem_trend in the same way. What is no number is left out.
std::string influx_lines(MessageKind kind, const std::string& line, const std::string& name);

}  // namespace kalfem
