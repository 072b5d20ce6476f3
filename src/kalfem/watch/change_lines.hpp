// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/live/change_monitor.hpp"

namespace kalfem {

/// What a ChangeMonitor says, as JSON and as files. Times are those of the stream: `origin` is that of the first sample
/// [s].

/// {"alarm": {"number": 1, "t": ..., "kind": "raised", "parameter": ..., "change": -0.031, ...}}
std::string alarm_line(const Alarm& alarm, const ChangeMonitor& monitor, double origin);

/// Alarms that stand, with what is known of them now.
nlohmann::ordered_json changes_now(const ChangeMonitor& monitor, double origin);

/// {"trend": {"day": ..., "windows": ..., "parameters": {...}}}
std::string trend_line(const TrendDay& day, const ChangeMonitor& monitor);

/// Every alarm that is kept, a line each.
std::string alarm_file(const ChangeMonitor& monitor, double origin);

/// A table (CSV): one line for each day and unknown, with mean, standard deviation and the 95 % band, as measured and
/// without the effects of the covariates. The last day may not be over.
std::string trend_table(const ChangeMonitor& monitor);

}  // namespace kalfem
