// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/free_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/isolated_values.hpp"
#include "kalfem/records/noise_level.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check(const Record& record, const FreeResponseOptions& options) {
  IssueList issues;
  const auto positive = [&](const char* name, double value) {
    if (!(value > 0.0) || !std::isfinite(value))
      issues.add({}, std::string(name) + " is " + std::to_string(value), "it must be positive and finite");
  };
  positive("the sampling rate", record.sample_rate);
  positive("hold", options.hold);
  positive("departure", options.departure);
  positive("noise_factor", options.noise_factor);
  positive("still", options.still);
  if (options.departure >= 0.5)
    issues.add({}, "departure is " + std::to_string(options.departure),
               "it must be a fraction of the largest excursion, below 0.5");
  if (options.samples < 1) issues.add({}, "samples is " + std::to_string(options.samples), "it must be at least 1");
  issues.raise();
}

/// Mean, standard deviation and range of the finite samples of each channel.
struct Spread {
  ArrayXd mean, deviation, range;
};

Spread spread(const MatrixXd& values, Index from, Index count) {
  const Index channels = values.rows();
  Spread result{ArrayXd::Zero(channels), ArrayXd::Zero(channels), ArrayXd::Zero(channels)};
  for (Index c = 0; c < channels; ++c) {
    const ArrayXd part = values.row(c).segment(from, count).transpose().array();
    const auto finite = part.isFinite();
    const double n = static_cast<double>(finite.count());
    if (n < 1.0) continue;
    const double mean = finite.select(part, 0.0).sum() / n;
    const double infinity = std::numeric_limits<double>::infinity();
    result.mean[c] = mean;
    result.deviation[c] = std::sqrt(finite.select(part - mean, 0.0).square().sum() / n);
    result.range[c] = finite.select(part, -infinity).maxCoeff() - finite.select(part, infinity).minCoeff();
  }
  return result;
}

/// By how much a channel may be off a position and still count as being there.
ArrayXd allowed_departure(const ArrayXd& excursion, const ArrayXd& noise, const FreeResponseOptions& options) {
  return (options.departure * excursion).max(options.noise_factor * noise);
}

bool away(const Record& record, Index sample, const ArrayXd& position, const ArrayXd& allowed) {
  return ((record.values.col(sample).array() - position).abs() > allowed).any();  // false for NaN
}

Index length_in_samples(const Record& record, double seconds) {
  return std::max<Index>(2, std::llround(std::min(seconds * record.sample_rate, 1e12)));
}

/// Range of the finite samples of each channel so far.
class Excursion {
public:
  explicit Excursion(const MatrixXd& values)
      : values_(values),
        low_(ArrayXd::Constant(values.rows(), std::numeric_limits<double>::infinity())),
        high_(-low_) {}

  /// Up to and with sample `last`; calls go forwards.
  ArrayXd until(Index last) {
    for (; next_ <= last; ++next_) {
      const ArrayXd now = values_.col(next_);
      low_ = now.isFinite().select(low_.min(now), low_);
      high_ = now.isFinite().select(high_.max(now), high_);
    }
    return (high_ - low_).max(0.0);
  }

private:
  const MatrixXd& values_;
  ArrayXd low_, high_;
  Index next_ = 0;
};

/// The longest time that a channel has taken from one turning point to the next, or from the start to the first: half a
/// period of an oscillation. A turn counts once the channel has gone back by more than what is allowed at rest.
class Swings {
public:
  Swings(const MatrixXd& values, Index from)
      : values_(values),
        next_(from),
        extreme_(values.col(from)),
        extreme_at_(static_cast<std::size_t>(values.rows()), from),
        turned_at_(extreme_at_),
        direction_(static_cast<std::size_t>(values.rows()), 0) {}

  /// Up to and with sample `last`; calls go forwards. 0 before the first turn.
  Index longest_until(Index last, const ArrayXd& allowed) {
    for (; next_ <= last; ++next_)
      for (Index c = 0; c < values_.rows(); ++c)
        if (std::isfinite(values_(c, next_))) follow(c, 2.0 * allowed[c]);
    return longest_;
  }

private:
  void follow(Index c, double back) {
    const auto channel = static_cast<std::size_t>(c);
    const double value = values_(c, next_), offset = value - extreme_[c];
    int& direction = direction_[channel];
    if (!std::isfinite(extreme_[c]) || offset * direction > 0.0) return move_extreme(c);
    if (std::abs(offset) <= back) return;
    if (direction != 0) {
      longest_ = std::max(longest_, extreme_at_[channel] - turned_at_[channel]);
      turned_at_[channel] = extreme_at_[channel];
    }
    direction = offset > 0.0 ? 1 : -1;
    move_extreme(c);
  }
  void move_extreme(Index c) {
    extreme_[c] = values_(c, next_);
    extreme_at_[static_cast<std::size_t>(c)] = next_;
  }

  const MatrixXd& values_;
  Index next_, longest_ = 0;
  ArrayXd extreme_;  ///< furthest value since the last turn
  std::vector<Index> extreme_at_, turned_at_;
  std::vector<int> direction_;  ///< 0: has not moved yet
};

/// Consecutive windows that stand still.
struct Standstill {
  Index first = 0, last = 0;  ///< samples
  ArrayXd allowed;            ///< departure of each channel when it began
  bool swung = false;         ///< the motion before it has turned at least once

  [[nodiscard]] Index length() const { return last - first + 1; }
};

/// About a quiet window channels may tremble by so many times what is allowed before the rest counts as disturbed.
constexpr double trembling = 2.0;

/// Windows of the length `still`, by their first samples.
struct Windows {
  std::vector<double> range;     ///< the largest of the channels', in parts of what +-allowed spans
  MatrixXd mean;                 ///< channels x windows
  std::vector<ArrayXd> allowed;  ///< by the excursion so far
  std::vector<Index> swing;      ///< the longest so far

  /// Whether `count` windows from `first` on stand still at one place, which takes one of them to be quiet; a rest that
  /// goes on may tremble.
  [[nodiscard]] bool stand(Index first, Index count, bool goes_on) const {
    const auto begin = range.begin() + first;
    if (!goes_on && *std::min_element(begin, begin + count) > 1.0) return false;
    if (!std::all_of(begin, begin + count, [](double each) { return each <= trembling; })) return false;
    const auto means = mean.middleCols(first, count).array();
    const ArrayXd moved = means.rowwise().maxCoeff() - means.rowwise().minCoeff();
    return (moved <= (goes_on ? trembling : 1.0) * 2.0 * allowed[static_cast<std::size_t>(first)]).all();
  }
};

Windows windows_of(const Record& record, Index from, Index length, const FreeResponseOptions& options) {
  const ArrayXd noise = noise_level(record.values);
  Excursion excursion(record.values);
  Swings swings(record.values, from);
  const Index count = std::max<Index>(0, record.samples() - from - length + 1);
  Windows windows{{}, MatrixXd(record.values.rows(), count), {}, {}};
  for (Index k = 0; k < count; ++k) {
    const Index first = from + k;
    windows.swing.push_back(swings.longest_until(first, allowed_departure(excursion.until(first), noise, options)));
    windows.allowed.push_back(allowed_departure(excursion.until(first + length - 1), noise, options));
    const Spread inside = spread(record.values, first, length);
    const bool known = record.values.middleCols(first, length).array().isFinite().any();
    const ArrayXd parts = inside.range / (2.0 * windows.allowed.back()).max(std::numeric_limits<double>::min());
    windows.range.push_back(known ? parts.maxCoeff() : std::numeric_limits<double>::infinity());
    windows.mean.col(k) = inside.mean;
  }
  return windows;
}

/// Runs of windows that stand still, each for as long as the longest swing: the pause at a turning point with an
/// amplitude well above what is allowed is shorter.
std::vector<Standstill> standstills(const Record& record, Index from, const FreeResponseOptions& options) {
  const Index length = length_in_samples(record, options.still);
  const Windows windows = windows_of(record, from, length, options);
  std::vector<Standstill> runs;
  bool open = false;
  for (Index k = 0; k < windows.mean.cols(); ++k) {
    const auto place = static_cast<std::size_t>(k);
    const Index count = std::max<Index>(1, windows.swing[place] - length + 1);
    const bool still = k + count <= windows.mean.cols() && windows.stand(k, count, open);
    const Index first = from + k, last = first + count + length - 2;
    if (still && !open) runs.push_back({first, last, windows.allowed[place], windows.swing[place] > 0});
    if (still) runs.back().last = last;
    open = still;
  }
  return runs;
}

/// Before the first turn a pause may be the turning point of a slow oscillation: a rest is no shorter than half of what
/// came before it, unless the record ends there.
bool lasts(const Record& record, Index from, const Standstill& run) {
  return run.swung || run.last + 1 == record.samples() || run.length() >= (run.first - from) / 2;
}

/// Row whose range is largest, measured by what counts as standing still.
Index most_moving(const Record& record, Index from, Index count, const ArrayXd& allowed) {
  Index channel = 0;
  (spread(record.values, from, count).range / allowed.max(1e-300)).maxCoeff(&channel);
  return channel;
}

/// Samples at which a channel passes a level, between two samples.
std::vector<Index> passages(const Record& record, Index channel, double level, Index from, Index to) {
  std::vector<Index> found;
  double before = 0.0;
  for (Index k = from; k < to; ++k) {
    const double offset = record.values(channel, k) - level;
    if (!std::isfinite(offset) || offset == 0.0) continue;
    if (before * offset < 0.0) found.push_back(k);
    before = offset;
  }
  return found;
}

Rest rest_of(const Record& record, Index from, const Standstill& run) {
  const auto second_half = [&](Index last) {
    const Index settled = (run.first + last) / 2;  // by then creeping and small oscillations have ended
    return std::pair(settled, spread(record.values, settled, last - settled + 1));
  };
  Index last = run.last;
  const ArrayXd rough = second_half(last).second.mean;
  while (last > (run.first + run.last) / 2 && away(record, last, rough, run.allowed)) --last;
  const auto [settled, rest] = second_half(last);
  Index end = from;
  for (Index k = from; k < settled; ++k)
    if (away(record, k, rest.mean, run.allowed)) end = k;
  return {end, last, record.time(end), rest.mean.matrix(), rest.deviation.matrix()};
}

/// Excursions, holds and rests are ranges, which one spike would decide.
Record without_spikes(const Record& record) {
  return {record.sample_rate, record.start, record.channels, without_isolated_values(record.values), record.used};
}

void check_sample(const Record& record, Index from) {
  if (from < 0 || from >= record.samples())
    throw InvalidInput("sample " + std::to_string(from) + " is outside the record",
                       "it has " + std::to_string(record.samples()) + " samples", "give a sample number of the record");
}

}  // namespace

std::optional<Release> find_release(const Record& given, const FreeResponseOptions& options) {
  check(given, options);
  const Record record = without_spikes(given);
  const Index hold = length_in_samples(record, options.hold), n = record.samples();
  if (n < hold + options.samples) return std::nullopt;
  const Spread held = spread(record.values, 0, hold);
  const ArrayXd excursion = spread(record.values, 0, n).range;
  const ArrayXd allowed = allowed_departure(excursion, held.deviation, options);
  // A channel that only makes noise would pass as held; one that moves in the hold does not.
  if ((held.range > 2.0 * allowed).any()) return std::nullopt;
  Index in_a_row = 0, first = 0;  // a missing sample neither counts nor ends the row
  for (Index k = 0; k < n; ++k) {
    if (away(record, k, held.mean, allowed)) {
      if (in_a_row++ == 0) first = k;
    } else if (record.values.col(k).allFinite()) {
      in_a_row = 0;
    }
    if (in_a_row < options.samples) continue;
    if (first < hold) return std::nullopt;
    return Release{first, record.time(first), held.mean.matrix()};
  }
  return std::nullopt;
}

std::optional<Rest> find_rest(const Record& given, Index from, const FreeResponseOptions& options) {
  check(given, options);
  check_sample(given, from);
  const Record record = without_spikes(given);
  for (const auto& run : standstills(record, from, options))
    if (lasts(record, from, run)) return rest_of(record, from, run);
  return std::nullopt;
}

std::optional<FreeResponseTimes> find_free_response(const Record& record, const FreeResponseOptions& options) {
  const auto release = find_release(record, options);
  if (!release) return std::nullopt;
  FreeResponseTimes times{*release, find_rest(record, release->sample, options)};
  if (!times.rest || times.rest->last + 1 == record.samples()) return times;
  Record undisturbed{record.sample_rate, record.start, record.channels};
  undisturbed.values = record.values.leftCols(times.rest->last + 1);
  if (const auto again = find_release(undisturbed, options))
    if (auto rest = find_rest(undisturbed, again->sample, options)) return FreeResponseTimes{*again, std::move(rest)};
  return times;
}

RestGuess guess_rest(const Record& given, Index from, const FreeResponseOptions& options) {
  check(given, options);
  check_sample(given, from);
  const Record record = without_spikes(given);
  const Index n = record.samples(), later = (from + n) / 2;
  const ArrayXd allowed = allowed_departure(spread(record.values, 0, n).range, noise_level(record.values), options);
  const Index channel = most_moving(record, later, n - later, allowed);
  const auto times = passages(record, channel, spread(record.values, later, n - later).mean[channel], later, n);
  const Index first = times.size() < 3 ? n - std::max<Index>(1, (n - from) / 4) : times[times.size() - 3];
  const Spread swing = spread(record.values, first, n - first);
  const double infinity = std::numeric_limits<double>::infinity();
  RestGuess guess{VectorXd(record.values.rows()), (0.5 * swing.range).max(allowed).matrix()};
  for (Index c = 0; c < record.values.rows(); ++c) {
    const ArrayXd part = record.values.row(c).tail(n - first).transpose().array();
    const auto finite = part.isFinite();
    guess.position[c] =
        finite.any() ? 0.5 * (finite.select(part, infinity).minCoeff() + finite.select(part, -infinity).maxCoeff())
                     : 0.0;
  }
  return guess;
}

}  // namespace kalfem
