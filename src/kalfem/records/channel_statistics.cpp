// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double median(VectorXd values) {
  double* middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

TimeBase of_stamps(const VectorXd& times) {
  TimeBase base{.start = times[0], .duration = times[times.size() - 1] - times[0]};
  const VectorXd intervals = times.tail(times.size() - 1) - times.head(times.size() - 1);
  const double typical = median(intervals);
  base.not_increasing = (intervals.array() <= 0.0).count();
  if (!(typical > 0.0)) return base;
  double squares = 0.0, regular = 0.0;
  Index count = 0;
  for (const double interval : intervals) {
    const double deviation = interval / typical - 1.0;
    if (deviation > 0.5) {
      ++base.gaps;
      base.missing += std::max<Index>(1, static_cast<Index>(std::min(std::round(deviation), 1e15)));
      base.longest_gap = std::max(base.longest_gap, interval);
    } else {
      squares += deviation * deviation;
      base.worst = std::max(base.worst, std::abs(deviation));
      regular += interval;
      ++count;
    }
  }
  // The mean: jitter and rounding move the median, but not the sum of the intervals.
  base.rate = regular > 0.0 ? static_cast<double>(count) / regular : 1.0 / typical;
  base.jitter = std::sqrt(squares / static_cast<double>(std::max<Index>(1, intervals.size() - base.gaps)));
  return base;
}

}  // namespace

TimeBase time_base(const MeasuredChannel& channel) {
  if (channel.times.size() > 1) return of_stamps(channel.times);
  TimeBase base{.start = channel.times.size() == 1 ? channel.times[0] : channel.start};
  if (!(channel.interval > 0.0)) return base;
  base.rate = 1.0 / channel.interval;
  base.duration = channel.interval * static_cast<double>(std::max<Index>(0, channel.values.size() - 1));
  return base;
}

namespace {

void count_missing(const VectorXd& values, ChannelStatistics& found) {
  Index length = 0;
  for (const double value : values) {
    if (std::isfinite(value)) {
      length = 0;
      continue;
    }
    ++found.missing;
    if (++length == 1) ++found.missing_stretches;
    found.longest_missing = std::max(found.longest_missing, length);
  }
}

/// Mean and size; sums of differences from the first number keep their digits on a large offset.
void measure_size(const VectorXd& present, ChannelStatistics& found) {
  found.lowest = present.minCoeff();
  found.highest = present.maxCoeff();
  const auto count = static_cast<double>(present.size());
  found.offset = present[0] + (present.array() / count - present[0] / count).sum();
  found.rms = std::sqrt((present.array() - found.offset).square().sum() / count);
  found.peak = std::max(found.highest - found.offset, found.offset - found.lowest);
}

/// Least squares of a straight line over the number of the sample.
void measure_drift(const VectorXd& values, ChannelStatistics& found) {
  double count = 0.0, mean = 0.0;
  for (Index k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) mean += (static_cast<double>(k) - mean) / ++count;
  double squares = 0.0, products = 0.0;
  for (Index k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    const double place = static_cast<double>(k) - mean;
    squares += place * place;
    products += place * (values[k] - found.offset);
  }
  if (!(squares > 0.0 && found.rms > 0.0)) return;
  const double slope = products / squares;
  found.drift = slope * static_cast<double>(values.size() - 1);
  found.drift_share = std::min(1.0, slope * slope * squares / (count * found.rms * found.rms));
}

/// The values that occur, ascending, with the number of their samples.
struct Level {
  double value = 0.0;
  Index samples = 0;
};

std::vector<Level> levels_of(VectorXd present) {
  std::sort(present.begin(), present.end());
  std::vector<Level> levels;
  for (const double value : present) {
    if (levels.empty() || levels.back().value != value) levels.push_back({value, 0});
    ++levels.back().samples;
  }
  return levels;
}

/// A stretch of samples of the same value, [first, end).
struct Stretch {
  Index first = 0, end = 0;
  [[nodiscard]] Index length() const { return end - first; }
};

std::vector<Stretch> stretches_at(const VectorXd& values, double level) {
  std::vector<Stretch> all;
  for (Index k = 0; k < values.size(); ++k) {
    if (values[k] != level) continue;
    if (all.empty() || all.back().end != k) all.push_back({k, k});
    all.back().end = k + 1;
  }
  return all;
}

/// A rounded extreme of a smooth signal falls by less than 9 quanta over the length of the stretch beside it; a
/// saturated one goes on as steeply as it came.
bool falls_steeply(const VectorXd& values, const Stretch& stretch, double level, double quantum) {
  if (stretch.length() < 3) return false;
  const double before = values[std::max<Index>(0, stretch.first - stretch.length())],
               behind = values[std::min(values.size() - 1, stretch.end - 1 + stretch.length())];
  return std::abs(level - before) + std::abs(level - behind) > 40.0 * quantum;
}

/// `levels` from the extreme inwards. The signal is clipped where samples pile up at the extreme: ten times as many as
/// at the ten levels next to it, or flat tops that a smooth signal does not have. Stretches at either end of the record
/// are a structure that is held.
std::optional<Clipping> clipping_at(const VectorXd& values, const std::vector<Level>& levels, double quantum) {
  if (levels.size() < 12) return std::nullopt;
  const double level = levels.front().value;
  auto stretches = stretches_at(values, level);
  std::erase_if(stretches, [&](const Stretch& each) { return each.first == 0 || each.end == values.size(); });
  Clipping clipping{.level = level, .times = static_cast<Index>(stretches.size())};
  Index steep = 0, beside = 0;
  for (const auto& stretch : stretches) {
    clipping.samples += stretch.length();
    if (falls_steeply(values, stretch, level, quantum)) ++steep;
  }
  for (std::size_t i = 1; i <= 10; ++i) beside += levels[i].samples;
  const bool piled = clipping.samples >= 4 && clipping.samples >= beside;
  return piled || 2 * steep > clipping.times ? std::optional(clipping) : std::nullopt;
}

/// The step of the converter: the smallest difference between levels, if a few hundred of them show it.
double quantum_of(const std::vector<Level>& levels) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < levels.size(); ++i) least = std::min(least, levels[i].value - levels[i - 1].value);
  return least;
}

void look_for_clipping(const VectorXd& values, std::vector<Level> levels, ChannelStatistics& found) {
  const double quantum = quantum_of(levels);
  // A signal that rests at zero between pulses is not clipped there.
  if (levels.front().value != 0.0) found.clipped_below = clipping_at(values, levels, quantum);
  std::ranges::reverse(levels);
  if (levels.front().value != 0.0) found.clipped_above = clipping_at(values, levels, quantum);
}

/// The longest stretch of equal samples between the extremes; it counts where it is twenty times as long as 99 % of
/// all.
void look_for_hold(const VectorXd& values, ChannelStatistics& found) {
  std::vector<Stretch> all;
  for (Index k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    if (all.empty() || all.back().end != k || values[all.back().first] != values[k]) all.push_back({k, k});
    all.back().end = k + 1;
  }
  if (all.size() < 100) return;
  const auto longest = *std::ranges::max_element(all, {}, &Stretch::length);
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(all.size() * 99 / 100), {}, &Stretch::length);
  const Index usual = all[all.size() * 99 / 100].length();
  const double value = values[longest.first];
  const bool at_extreme = value == found.highest || value == found.lowest;
  if (!at_extreme && longest.length() >= 20 * usual) found.hold = Hold{longest.first, longest.length()};
}

DeadReason dead_reason(const std::vector<Level>& levels) {
  if (levels.size() == 1) return DeadReason::constant;
  const Index most = std::ranges::max(levels, {}, &Level::samples).samples;
  Index all = 0;
  for (const auto& level : levels) all += level.samples;
  const bool flickers =
      levels.size() <= 3 && all >= 1000 && static_cast<double>(most) > 0.98 * static_cast<double>(all);
  return flickers ? DeadReason::two_levels : DeadReason::none;
}

/// The samples at their times on an even grid, with NaN in the gaps, so that what is behind a gap keeps its phase.
VectorXd with_gaps(const MeasuredChannel& channel, const TimeBase& time) {
  constexpr double most = 4.0;  ///< times as many places as samples
  const double places = std::round(time.duration * time.rate) + 1.0;
  const Index count = channel.values.size();
  if (time.gaps == 0 || time.not_increasing > 0 || channel.times.size() != count || !channel.times.allFinite() ||
      !(places <= most * static_cast<double>(count)))
    return channel.values;
  VectorXd placed = VectorXd::Constant(static_cast<Index>(places), std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < count; ++k) {
    const auto place = static_cast<Index>(std::round((channel.times[k] - channel.times[0]) * time.rate));
    placed[std::clamp<Index>(place, 0, placed.size() - 1)] = channel.values[k];
  }
  return placed;
}

VectorXd finite_part(const VectorXd& values) {
  VectorXd present(values.size());
  return present.head(
      std::copy_if(values.begin(), values.end(), present.begin(), [](double v) { return std::isfinite(v); }) -
      present.begin());
}

}  // namespace

ChannelStatistics statistics_of(const MeasuredChannel& channel) {
  ChannelStatistics found{.time = time_base(channel), .samples = channel.values.size()};
  if (found.samples == 0) {
    found.dead = DeadReason::no_samples;
    return found;
  }
  count_missing(channel.values, found);
  const VectorXd present = finite_part(channel.values);
  if (present.size() == 0) {
    found.dead = DeadReason::no_numbers;
    return found;
  }
  measure_size(present, found);
  const auto levels = levels_of(present);
  found.dead = dead_reason(levels);
  if (found.dead != DeadReason::none) return found;
  measure_drift(channel.values, found);
  look_for_clipping(channel.values, levels, found);
  look_for_hold(channel.values, found);
  if (found.time.rate > 0.0 && found.time.jitter < 0.3)
    found.frequencies = spectral_peaks(with_gaps(channel, found.time), found.time.rate, 3);
  return found;
}

}  // namespace kalfem
