// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>

#include "kalfem/live/live_state.hpp"

namespace kalfem {

/// The latest events of a filter, and how many there were.
class EventLog {
public:
  explicit EventLog(int most) : most_(static_cast<std::size_t>(most)) {}

  void add(FilterEvent event) {
    events_.push_back(std::move(event));
    ++total_;
    if (events_.size() > most_) events_.pop_front();
  }
  /// The latest one of a channel; nothing where it is no longer kept.
  [[nodiscard]] const FilterEvent* latest(const std::string& channel) const {
    for (auto event = events_.rbegin(); event != events_.rend(); ++event)
      if (event->channel == channel) return &*event;
    return nullptr;
  }

  [[nodiscard]] const std::deque<FilterEvent>& events() const { return events_; }
  [[nodiscard]] std::int64_t total() const { return total_; }  ///< those that are no longer kept among them

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.total_);
    archive.each(self.events_, [&](auto& event) {
      archive(event.time);
      archive(event.kind);
      archive(event.channel);
      archive(event.text);
    });
  }

private:
  std::size_t most_;
  std::deque<FilterEvent> events_;
  std::int64_t total_ = 0;
};

}  // namespace kalfem
