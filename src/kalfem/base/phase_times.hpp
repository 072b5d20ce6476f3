// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/stopwatch.hpp"

namespace kalfem {

/// Wall time of a job's phases [s], in the order in which they began. A phase that comes again adds to its time.
class PhaseTimes {
public:
  void add(const std::string& phase, double seconds) {
    for (auto& [name, sum] : phases_)
      if (name == phase) return void(sum += seconds);
    phases_.emplace_back(phase, seconds);
  }

  void add(const PhaseTimes& other) {
    for (const auto& [name, seconds] : other.phases_) add(name, seconds);
  }

  /// Calls the work, adds its time, and hands on what it returns.
  template <typename Work>
  auto measure(const std::string& phase, Work work) {
    struct Lap {
      PhaseTimes& times;
      const std::string& phase;
      Stopwatch watch = {};
      ~Lap() { times.add(phase, watch.seconds()); }
    } lap{*this, phase};
    return work();
  }

  [[nodiscard]] const std::vector<std::pair<std::string, double>>& list() const& { return phases_; }
  void list() && = delete;  ///< of a temporary: it would end before its list is read

private:
  std::vector<std::pair<std::string, double>> phases_;
};

}  // namespace kalfem
