// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "kalfem/live/live_state.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The health of a filter over the latest minute, hour and day of its stream. It is looked at once a second; the looks
/// stand in bins of a second, a minute and an hour, so that what is kept does not grow.
class HealthSpans {
public:
  /// `step`: from sample to sample [s].
  explicit HealthSpans(double step);

  /// A sample: `nis` over so many channels, not a number where none was there. Returns whether it is time to look().
  bool add(double nis, long channels);
  void look(FilterCondition condition, const Verdict& verdict);

  [[nodiscard]] SpanHealth of(HealthSpan span) const;

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.samples_);
    for (auto* bin : {&self.second_, &self.minute_, &self.hour_}) transfer_bin(*bin, archive);
    for (auto* bins : {&self.seconds_, &self.minutes_, &self.hours_})
      archive.each(*bins, [&](auto& bin) { transfer_bin(bin, archive); });
  }

private:
  struct Seen {
    std::string code, subject;
    long looks = 0;
  };
  struct Bin {
    long looks = 0;
    std::array<long, 5> conditions{};  ///< looks by FilterCondition
    double nis = 0.0;                  ///< sum
    long samples = 0, channels = 0;    ///< with a NIS; sum of the channels that they had
    std::vector<Seen> reasons;

    void add(const Bin& other);
    void see(const std::string& code, const std::string& subject, long looks);
  };
  static void transfer_bin(auto& bin, auto& archive) {
    archive(bin.looks);
    for (auto& looks : bin.conditions) archive(looks);
    archive(bin.nis);
    archive(bin.samples);
    archive(bin.channels);
    archive.each(bin.reasons, [&](auto& seen) {
      archive(seen.code);
      archive(seen.subject);
      archive(seen.looks);
    });
  }

  double step_;
  long per_look_;                              ///< samples
  long samples_ = 0;                           ///< since the last look
  Bin second_, minute_, hour_;                 ///< that are not over
  std::deque<Bin> seconds_, minutes_, hours_;  ///< the latest 60, 60 and 24
};

}  // namespace kalfem
