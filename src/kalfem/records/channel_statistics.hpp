// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/records/measured_file.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

/// Times of a channel's samples. Gaps and jitter are judged against the typical interval, the median.
struct TimeBase {
  double rate = 0.0;                ///< 1 / typical interval [Hz]; 0: not known
  double start = 0.0;               ///< [s]
  double duration = 0.0;            ///< from the first sample to the last [s]; 0 without a rate
  double jitter = 0.0;              ///< standard deviation of the intervals about the typical one, per interval
  double worst = 0.0;               ///< largest such deviation, per interval; gaps do not count
  Eigen::Index gaps = 0;            ///< intervals of more than 1.5 typical ones
  Eigen::Index missing = 0;         ///< samples that would fill them
  double longest_gap = 0.0;         ///< [s]
  Eigen::Index not_increasing = 0;  ///< times that are not behind the one before
};

TimeBase time_base(const MeasuredChannel& channel);

/// The signal stands at its highest or lowest value as it does where an amplifier or converter saturates.
struct Clipping {
  double level = 0.0;
  Eigen::Index samples = 0;  ///< at this level
  Eigen::Index times = 0;    ///< stretches of such samples
};

/// A part of a signal that does not change.
struct Hold {
  Eigen::Index first = 0;
  Eigen::Index samples = 0;
};

/// Why a channel looks as if it measured nothing.
enum class DeadReason { none, no_samples, no_numbers, constant, two_levels };

/// What the samples of a channel say by themselves, in the channel's unit.
struct ChannelStatistics {
  TimeBase time;
  Eigen::Index samples = 0;
  Eigen::Index missing = 0;  ///< samples that are not finite
  Eigen::Index missing_stretches = 0;
  Eigen::Index longest_missing = 0;  ///< samples of the longest stretch
  double lowest = 0.0, highest = 0.0;
  double offset = 0.0;       ///< mean
  double rms = 0.0;          ///< about the mean
  double peak = 0.0;         ///< largest deviation from the mean
  double drift = 0.0;        ///< of the straight line of least squares, from the first sample to the last
  double drift_share = 0.0;  ///< of the variance that this line explains
  DeadReason dead = DeadReason::none;
  std::optional<Clipping> clipped_above = {}, clipped_below = {};
  std::optional<Hold> hold = {};  ///< the longest, where it is too long for this signal: a sensor that sticks
  std::vector<SpectralPeak> frequencies = {};  ///< the strongest first, up to three

  /// Whether the straight line is more than what one swing of the signal would leave.
  [[nodiscard]] bool drifts() const { return drift_share > 0.2; }
};

/// Missing samples are left out; in the spectrum they count as the mean. Frequencies are left out where the rate is not
/// known.
ChannelStatistics statistics_of(const MeasuredChannel& channel);

}  // namespace kalfem
