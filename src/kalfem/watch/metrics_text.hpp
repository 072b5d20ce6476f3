// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kalfem {

/// What is known of one case that is watched.
struct WatchedHealth {
  std::string name;
  bool running = true;         ///< false once it has ended or failed
  std::string why_not = {};    ///< it does not run
  double silent_for = 0.0;     ///< since the last sample came [s]
  std::int64_t alarms = 0;     ///< given since the start
  std::string estimates = {};  ///< its latest line of estimates; empty: none yet
};

/// Metrics in the text format of Prometheus: kalfem_up, kalfem_condition, kalfem_samples_total, kalfem_late_total,
/// kalfem_bad_lines_total, kalfem_stream_seconds, kalfem_silent_seconds, kalfem_alarms_total, kalfem_changes,
/// kalfem_parameter, kalfem_parameter_std.
std::string metrics_text(const std::vector<WatchedHealth>& cases);

/// Whether all cases run and give estimates that can be relied on.
bool is_healthy(const std::vector<WatchedHealth>& cases);
/// {"healthy": true, "cases": {"tower": {"running": true, "condition": "consistent", "silent_for": 0.2}}}
std::string health_text(const std::vector<WatchedHealth>& cases);

}  // namespace kalfem
