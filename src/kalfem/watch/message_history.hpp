// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <string>

#include "kalfem/watch/watcher.hpp"

namespace kalfem {

/// The latest messages of all cases that are watched, for pages that follow them: any thread adds, any thread reads.
/// The oldest are dropped where all together are longer than `most_bytes`, so a page that reads slowly misses some.
class MessageHistory {
public:
  explicit MessageHistory(std::size_t most_bytes = 8'000'000) : most_bytes_(most_bytes) {}

  /// `line`: a JSON object without a line break.
  void add(MessageKind kind, const std::string& name, const std::string& line);

  /// The messages after the first `seen`, up to about `most_bytes` and at least one, as server-sent events (WHATWG
  /// HTML, 9.2): "data: {"case": "tower", "kind": "estimates", "line": {...}}" and an empty line each. `seen` is moved
  /// behind them.
  std::string events_after(std::int64_t& seen, std::size_t most_bytes) const;

private:
  mutable std::mutex lock_;
  std::size_t most_bytes_;
  std::deque<std::string> events_;
  std::size_t bytes_ = 0;
  std::int64_t added_ = 0;  ///< so many, those that were dropped among them
};

}  // namespace kalfem
