// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// Turns messages of a broker into the lines that StreamLines reads. The last level of a topic, "a3" of "tower/a3", is
/// the channel of messages that hold one.
///     {"t": 1.25, "dt": 0.002, "a3": [0.31, 0.28]}                                any channels, as a line
///     {"t0": 1.25, "dt": 0.002, "counter": 17, "unit": "g", "values": [0.31, 0.28]}   the topic's channel
///     "KFB1", counter (uint32), t0 [s], dt [s], values (float64 each), little-endian   the same as a binary block
/// `counter` counts the blocks of a topic: one that comes again is dropped, missing ones are counted. `unit` and
/// `counter` may be left out of JSON.
class MessageLines {
public:
  /// A line without a line break; nothing for a block that has come before. Throws InvalidInput for a message that
  /// holds no samples.
  std::optional<std::string> line_of(const std::string& topic, std::string_view payload);

  [[nodiscard]] std::int64_t repeated() const { return repeated_; }  ///< blocks that came again
  [[nodiscard]] std::int64_t lost() const { return lost_; }          ///< that the counters miss

private:
  [[nodiscard]] bool is_new(const std::string& topic, std::uint32_t counter);

  std::map<std::string, std::uint32_t> counters_;  ///< the latest of each topic
  std::int64_t repeated_ = 0, lost_ = 0;
};

/// A binary block of MessageLines.
std::string binary_block(std::uint32_t counter, double start, double interval, const std::vector<double>& values);

}  // namespace kalfem
