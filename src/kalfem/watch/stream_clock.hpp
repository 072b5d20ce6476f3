// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// Where a block stands, by the clock of the filter.
struct PlacedBlock {
  /// Of its first sample, on the grid of samples [s]; empty: it is too far ahead to be used.
  std::optional<double> time;
  double jump = 0.0;  ///< by which the clock of the stream has been found to have jumped: its origin moves by it [s]
  std::string words;  ///< what is to be told; empty: nothing
};

/// From the clock of a stream to that of a filter, which counts samples: clocks drift against the sampling rate, are
/// set, and jump.
///
/// A channel's times need not lie on the grid of samples: its phase is followed, so that a clock that drifts loses and
/// invents no sample. A block that is off by more than a tenth of a sample is refused; where the next one is off by as
/// much, the clock was set: it is told, and the new phase is taken. Blocks that lie further ahead than the longest gap,
/// or come later than the horizon, are strays: a single one has a wrong time. Where all blocks are strays that follow
/// each other, for 10 s ahead or 60 s behind, the clock has jumped, and the stream goes on from there.
class StreamClock {
public:
  /// `horizon`, `longest_gap` [s]: as in LiveOptions.
  StreamClock(double rate, std::size_t channels, double horizon, double longest_gap)
      : rate_(rate), horizon_(horizon), longest_gap_(longest_gap), phases_(channels) {}

  /// A block of so many values that begins at a time from the origin on [s]; `newest`: time of the latest sample of any
  /// channel, empty before the first. Throws InvalidInput for a block that lies between two samples, and for the first
  /// of the blocks that are too far ahead.
  PlacedBlock place(std::size_t channel, double time, std::ptrdiff_t count, std::optional<double> newest);

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive.each(self.phases_, [&](auto& phase) { archive.maybe(phase, [&](auto& samples) { archive(samples); }); });
    archive(self.moved_);
    archive(self.latest_phase_);
    archive(self.strays_from_);
    archive(self.strays_to_);
  }

private:
  [[nodiscard]] double on_the_grid(std::size_t channel, double time, double phase, std::string& words);
  [[nodiscard]] bool follows_other_strays(double time, double duration);

  double rate_, horizon_, longest_gap_;
  std::vector<std::optional<double>> phases_;  ///< of each channel [samples]
  std::optional<double> moved_;                ///< by which the latest block was off, if by much [samples]
  double latest_phase_ = 0.0;                  ///< of any channel: that of one that has not come yet
  std::optional<double> strays_from_;          ///< begin of the first of the strays that follow each other [s]
  double strays_to_ = 0.0;                     ///< end of the last one
};

}  // namespace kalfem
