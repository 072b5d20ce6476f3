// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/sensor_events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index shortest_stretch = 20;       ///< samples of a dropout or of a constant value
constexpr double far_longer = 4.0;           ///< than nearly all other stretches of the channel
constexpr double nearly_all = 0.99;          ///< of the stretches, by their number
constexpr double moves = 0.1;                ///< rms of a channel in a stretch over that of its record
constexpr double contradiction = 2.0;        ///< deviations
constexpr double regular_steps = 0.9;        ///< part of a channel's samples that follow at its own rate
constexpr Index shortest_window = 100;       ///< samples
constexpr Index windows = 40;                ///< of a record
constexpr double alive = 0.7, silent = 0.3;  ///< correlation of a channel with its prediction
constexpr double quieter = 0.5;              ///< rms of a silent channel over that of its prediction
constexpr Index run_at_extreme = 3;          ///< samples in succession
constexpr int fewest_runs = 3;               ///< at one extreme
constexpr double plain = 10.0;               ///< deviations of an outlier that nothing else explains
constexpr double near_prediction = 3.5;      ///< deviations of the samples beside an outlier
constexpr Index longest_burst = 3;           ///< outliers in succession
constexpr double most_outliers = 0.05;       ///< of the samples of a channel
constexpr double bulk = 2.0;                 ///< median of |e| over that of a normal variable
constexpr double median_of_normal = 0.6745;

/// A run of samples for which something holds.
struct Stretch {
  Index begin = 0, end = 0;  ///< [begin, end)
  Index count = 0;           ///< samples with a number, or without where these are counted
};

/// Length from which a stretch is far longer than nearly all.
Index long_stretch(const std::vector<Stretch>& all) {
  std::vector<Index> lengths;
  for (const auto& each : all) lengths.push_back(each.count);
  if (lengths.empty()) return shortest_stretch;
  const auto place = static_cast<std::ptrdiff_t>(nearly_all * static_cast<double>(lengths.size() - 1));
  std::ranges::nth_element(lengths, lengths.begin() + place);
  const auto usual = static_cast<double>(lengths.size() > 1 ? lengths[static_cast<std::size_t>(place)] : 1);
  return std::max(shortest_stretch, static_cast<Index>(far_longer * usual));
}

template <class Holds>
std::vector<Stretch> stretches(Index samples, const Holds& holds) {
  std::vector<Stretch> found;
  for (Index k = 0; k < samples; ++k) {
    if (!holds(k)) continue;
    if (found.empty() || found.back().end != k) found.push_back({k, k, 0});
    found.back().end = k + 1;
    ++found.back().count;
  }
  return found;
}

/// Runs of equal values; samples without a number do not end one.
std::vector<Stretch> equal_values(const VectorXd& values) {
  std::vector<Stretch> found;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (Index k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    if (!(values[k] == last)) found.push_back({k, k, 0});
    last = values[k];
    found.back().end = k + 1;
    ++found.back().count;
  }
  if (!found.empty()) found.back().end = values.size();
  return found;
}

/// Sums over samples that are there.
struct Spread {
  Index count = 0;
  double mean = 0.0, rms = 0.0;  ///< rms about the mean
};

Spread spread_of(const VectorXd& values) {
  Spread found;
  double sum = 0.0, square = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) ++found.count, sum += value;
  if (found.count == 0) return found;
  found.mean = sum / static_cast<double>(found.count);
  for (const double value : values)
    if (std::isfinite(value)) square += (value - found.mean) * (value - found.mean);
  found.rms = std::sqrt(square / static_cast<double>(found.count));
  return found;
}

/// Whether nothing moves in a stretch of a channel that another channel shows: that rests too, though not exactly.
bool everything_rests(const Record& record, Index channel, const Stretch& stretch) {
  bool rests = false;
  for (Index other = 0; other < record.values.rows(); ++other) {
    if (other == channel) continue;
    const VectorXd values = record.values.row(other).transpose();
    const Spread there = spread_of(values.segment(stretch.begin, stretch.end - stretch.begin));
    if (there.rms == 0.0) continue;
    if (there.rms > moves * spread_of(values).rms) return false;
    rests = true;
  }
  return rests;
}

std::string name_of(const Record& record, Index channel) {
  return record.channels[static_cast<std::size_t>(channel)].name;
}

/// The channel, its prediction and how they agree in some samples.
struct Agreement {
  Spread measured, predicted;
  double correlation = 0.0, deviation = 0.0;  ///< mean of the expected deviation
};

Agreement agreement(const VectorXd& y, const VectorXd& innovation, const VectorXd& deviation) {
  Agreement found;
  const VectorXd predicted = y - innovation;
  const VectorXd seen = predicted.array().isFinite().select(y, std::numeric_limits<double>::quiet_NaN());
  found.measured = spread_of(seen);
  found.predicted = spread_of(predicted);
  if (found.predicted.count == 0) return found;
  double product = 0.0;
  for (Index k = 0; k < y.size(); ++k) {
    if (!std::isfinite(predicted[k])) continue;
    product += (y[k] - found.measured.mean) * (predicted[k] - found.predicted.mean);
    found.deviation += deviation[k] / static_cast<double>(found.predicted.count);
  }
  const double scale = static_cast<double>(found.predicted.count) * found.measured.rms * found.predicted.rms;
  found.correlation = scale > 0.0 ? product / scale : 0.0;
  return found;
}

/// The most likely sample at which a channel stopped to follow its prediction, in [begin, end): before it the
/// innovation is normal as expected, from it on the channel itself is, about `rest`.
Index change_point(const VectorXd& y, const VectorXd& innovation, const VectorXd& deviation, const Spread& rest,
                   Index begin, Index end) {
  Index best = begin;
  double sum = 0.0, highest = 0.0;
  const double s = std::max(rest.rms, 1e-300);
  for (Index k = begin; k < end; ++k) {
    if (!std::isfinite(innovation[k])) continue;
    const double e = innovation[k] / deviation[k], r = (y[k] - rest.mean) / s;
    sum += 0.5 * (r * r - e * e) + std::log(s / deviation[k]);
    if (sum <= highest) continue;
    highest = sum;
    best = k + 1;
  }
  return best;
}

}  // namespace

std::string to_string(EventKind kind) {
  switch (kind) {
    case EventKind::missing:
      return "missing";
    case EventKind::dropout:
      return "dropout";
    case EventKind::dead:
      return "dead";
    case EventKind::stuck:
      return "stuck";
    case EventKind::saturated:
      return "saturated";
    case EventKind::outliers:
      return "outliers";
    case EventKind::jump:
      return "jump";
    case EventKind::drift:
      return "drift";
  }
  return "";
}

namespace {

/// Usual number of the record's times from one sample of a channel to the next: more than one where it is slower than
/// the record. One where its gaps are of any length.
Index usual_step(const Eigen::Ref<const Eigen::Array<bool, 1, Eigen::Dynamic>>& missing) {
  std::vector<Index> steps;
  Index last = -1;
  for (Index k = 0; k < missing.size(); ++k) {
    if (missing[k]) continue;
    if (last >= 0) steps.push_back(k - last);
    last = k;
  }
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::ranges::nth_element(steps, middle);
  const Index usual = *middle;
  const auto regular = std::ranges::count_if(steps, [&](Index step) { return 2 * std::abs(step - usual) <= usual; });
  return static_cast<double>(regular) >= regular_steps * static_cast<double>(steps.size()) ? usual : 1;
}

}  // namespace

std::vector<SensorEvent> missing_samples(const Record& record) {
  std::vector<SensorEvent> events;
  const Index samples = record.samples_used(), rows = record.values.rows();
  const Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing =
      !record.values.leftCols(samples).array().isFinite();
  Eigen::Array<bool, Eigen::Dynamic, 1> in_dropout = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(samples, false);
  const auto all = stretches(samples, [&](Index k) { return missing.col(k).all(); });
  for (const auto& each : all) {
    if (each.count < long_stretch(all)) continue;
    in_dropout.segment(each.begin, each.count) = true;
    events.push_back({EventKind::dropout, "", record.time(each.begin), record.time(each.end - 1), each.count,
                      fmt::format("no sensor has a sample from {:.6g} to {:.6g} s", record.time(each.begin),
                                  record.time(each.end - 1))});
  }
  for (Index i = 0; i < rows; ++i) {
    const auto own = stretches(samples, [&](Index k) { return missing(i, k) && !in_dropout[k]; });
    SensorEvent rest{EventKind::missing, name_of(record, i)};
    const Index step = usual_step(missing.row(i));
    for (const auto& each : own) {
      if (step > 1 && 2 * (each.count + 1) <= 3 * step) continue;
      const double from = record.time(each.begin), to = record.time(each.end - 1);
      if (each.count >= long_stretch(own)) {
        events.push_back({EventKind::dropout, name_of(record, i), from, to, each.count,
                          fmt::format("'{}' has no sample from {:.6g} to {:.6g} s", name_of(record, i), from, to)});
        continue;
      }
      if (rest.count == 0) rest.from = from;
      rest.to = to;
      rest.count += step > 1 ? (2 * (each.count + 1) + step) / (2 * step) - 1 : each.count;
    }
    if (rest.count == 0) continue;
    rest.text = fmt::format("{} of {} samples of '{}' are missing", rest.count, samples / step, rest.channel);
    events.push_back(std::move(rest));
  }
  return events;
}

std::vector<HeldOutSamples> constant_stretches(const Record& record) {
  std::vector<HeldOutSamples> found;
  for (Index i = 0; i < record.values.rows(); ++i) {
    const auto runs = equal_values(record.values.row(i).head(record.samples_used()).transpose());
    if (runs.size() < 2) continue;  // constant throughout: accepted as it is, or refused before
    const Index limit = long_stretch(runs);
    for (const auto& run : runs)
      if (run.count >= limit && !everything_rests(record, i, run)) found.push_back({i, run.begin, run.end});
  }
  return found;
}

bool contradicted(const EstimationResult& result, const HeldOutSamples& stretch) {
  std::vector<double> values, predictions;
  double square = 0.0, deviation = 0.0;
  for (const auto& each : result.set_aside) {
    if (each.outlier || each.channel != stretch.channel || each.sample < stretch.begin || each.sample >= stretch.end)
      continue;
    predictions.push_back(-each.innovation);  // about the constant value
    square += each.innovation * each.innovation / (each.deviation * each.deviation);
    deviation += each.deviation;
  }
  if (predictions.empty()) return false;
  const auto count = static_cast<double>(predictions.size());
  const Spread moved = spread_of(VectorXd::Map(predictions.data(), std::ssize(predictions)));
  return std::sqrt(square / count) > contradiction || moved.rms > contradiction * deviation / count;
}

std::vector<HeldOutSamples> silent_stretches(const Record& measured, const EstimationResult& result) {
  std::vector<HeldOutSamples> found;
  const Index samples = measured.samples_used(), length = std::max(shortest_window, samples / windows);
  for (Index i = 0; i < measured.values.rows(); ++i) {
    const VectorXd y = measured.values.row(i).transpose(), innovation = result.innovation.row(i).transpose(),
                   deviation = result.innovation_deviation.row(i).transpose();
    const auto between = [&](Index begin, Index end) {
      const Index count = end - begin;
      return agreement(y.segment(begin, count), innovation.segment(begin, count), deviation.segment(begin, count));
    };
    Index begin_of_silence = samples, end_of_life = 0, following = 0, silences = 0;
    for (Index begin = 0; begin + length <= samples; begin += length) {
      const Agreement part = between(begin, begin + length);
      if (part.predicted.count < length / 4 || part.predicted.rms < contradiction * part.deviation) continue;
      if (part.correlation > alive) ++following, end_of_life = begin + length, begin_of_silence = samples, silences = 0;
      if (part.correlation > silent || part.measured.rms > quieter * part.predicted.rms) continue;
      begin_of_silence = std::min(begin_of_silence, begin);
      ++silences;
    }
    const Index before = end_of_life / length;
    if (silences < 2 || following < std::max<Index>(2, before / 2)) continue;
    const Spread rest = between(begin_of_silence, samples).measured;
    const Index from = std::max<Index>(0, end_of_life - length), to = std::min(samples, begin_of_silence + length);
    found.push_back({i, change_point(y, innovation, deviation, rest, from, to), samples});
  }
  return found;
}

std::vector<HeldOutSamples> saturated_samples(const Record& measured, const EstimationResult& result) {
  std::vector<HeldOutSamples> found;
  for (Index i = 0; i < measured.values.rows(); ++i) {
    const VectorXd y = measured.values.row(i).head(measured.samples_used()).transpose();
    const auto there = y.array().isFinite();
    if (!there.any()) continue;
    const auto runs = equal_values(y);
    for (const double outward : {1.0, -1.0}) {
      const double extreme = outward * (there.select(outward * y.array(), -1e300)).maxCoeff();
      std::vector<HeldOutSamples> own;
      double sum = 0.0;
      Index count = 0;
      for (const auto& run : runs) {
        if (run.count < run_at_extreme || y[run.begin] != extreme) continue;
        own.push_back({i, run.begin, run.begin + run.count});
        for (Index k = run.begin; k < run.begin + run.count; ++k)
          if (const double e = result.innovation(i, k) / result.innovation_deviation(i, k); std::isfinite(e))
            sum -= outward * e, ++count;
      }
      if (std::ssize(own) < fewest_runs || count == 0 || sum < contradiction * static_cast<double>(count)) continue;
      found.insert(found.end(), own.begin(), own.end());
    }
  }
  return found;
}

bool shows_outliers(const EstimationResult& result, Index first) {
  for (Index i = 0; i < result.innovation.rows(); ++i) {
    std::vector<double> sizes;
    for (Index k = first; k < result.innovation.cols(); ++k)
      if (const double e = result.innovation(i, k) / result.innovation_deviation(i, k); std::isfinite(e))
        sizes.push_back(std::abs(e));
    if (sizes.size() < static_cast<std::size_t>(shortest_stretch)) continue;
    const auto count = std::ssize(sizes);
    const auto far = stretches(count, [&](Index k) { return sizes[static_cast<std::size_t>(k)] > near_prediction; });
    Index outliers = 0, single = 0;
    double largest = 0.0;
    for (const auto& each : far) {
      double height = 0.0;
      for (Index k = each.begin; k < each.end; ++k) height = std::max(height, sizes[static_cast<std::size_t>(k)]);
      if (height < 2.0 * near_prediction) continue;
      outliers += each.count;
      if (each.count > longest_burst) continue;
      single += each.count;
      largest = std::max(largest, height);
    }
    std::ranges::nth_element(sizes, sizes.begin() + count / 2);
    const double middle = sizes[static_cast<std::size_t>(count / 2)];
    if (largest > plain && static_cast<double>(outliers) < most_outliers * static_cast<double>(count) &&
        2 * single > outliers && middle < bulk * median_of_normal)
      return true;
  }
  return false;
}

namespace {

/// The kind of a stretch that was held out. What lies at an extreme for a short while is saturation.
EventKind kind_of(const Record& measured, const HeldOutSamples& stretch) {
  if (stretch.end >= measured.samples_used()) return EventKind::dead;
  return stretch.end - stretch.begin < shortest_stretch ? EventKind::saturated : EventKind::stuck;
}

std::string text_of(const SensorEvent& event, const Record& measured) {
  const Index i = measured.find(event.channel);
  const double value = measured.values(i, event.samples.front()), last = measured.values(i, event.samples.back());
  const std::string& unit = measured.channels[static_cast<std::size_t>(i)].unit;
  switch (event.kind) {
    case EventKind::dead:
      return fmt::format(
          "'{}' is dead from {:.6g} s on: it {} while the model and the other sensors move; it is not used "
          "from there on",
          event.channel, event.from, value == last ? fmt::format("holds {:.4g} {}", value, unit) : "shows noise only");
    case EventKind::stuck:
      return fmt::format(
          "'{}' holds {:.4g} {} from {:.6g} to {:.6g} s while the model and the other sensors move; it is not "
          "used there",
          event.channel, value, unit, event.from, event.to);
    case EventKind::saturated:
      return fmt::format(
          "{} samples of '{}' from {:.6g} to {:.6g} s stand at the limit of the sensor; they are not used", event.count,
          event.channel, event.from, event.to);
    default:
      return "";
  }
}

void add(SensorEvent& event, const Record& measured, Index sample) {
  if (event.count == 0) event.from = measured.time(sample);
  event.to = std::max(event.to, measured.time(sample));
  event.from = std::min(event.from, measured.time(sample));
  ++event.count;
  event.samples.push_back(sample);
}

}  // namespace

std::vector<SensorEvent> events_of(const Record& measured, const EstimationResult& result,
                                   const std::vector<HeldOutSamples>& held_out, double limit) {
  std::vector<SensorEvent> events;
  for (const auto& stretch : held_out) {
    SensorEvent event{kind_of(measured, stretch), name_of(measured, stretch.channel)};
    const auto same = [&](const SensorEvent& other) {
      return event.kind == EventKind::saturated && other.kind == event.kind && other.channel == event.channel;
    };
    const auto before = std::ranges::find_if(events, same);
    SensorEvent& own = before != events.end() ? *before : events.emplace_back(std::move(event));
    for (Index k = stretch.begin; k < stretch.end; ++k)
      if (std::isfinite(measured.values(stretch.channel, k))) add(own, measured, k);
  }
  std::erase_if(events, [](const SensorEvent& event) { return event.count == 0; });
  for (auto& event : events) event.text = text_of(event, measured);
  for (Index i = 0; i < measured.values.rows(); ++i) {
    SensorEvent event{EventKind::outliers, name_of(measured, i)};
    double worst = 0.0, time = 0.0;
    for (const auto& each : result.set_aside) {
      if (!each.outlier || each.channel != i) continue;
      add(event, measured, each.sample);
      const double e = std::abs(each.innovation / each.deviation);
      if (e > worst) worst = e, time = measured.time(each.sample);
    }
    if (event.count == 0) continue;
    event.text = fmt::format(
        "{} of {} samples of '{}' lie more than {:.2g} deviations from their prediction, the worst at {:.6g} s by "
        "{:.3g}; "
        "they hardly count",
        event.count, measured.samples_used(), event.channel, limit, time, worst);
    events.push_back(std::move(event));
  }
  return events;
}

Record without(Record record, const std::vector<SensorEvent>& events) {
  for (const auto& event : events) {
    const Index row = record.find(event.channel);
    if (row < 0) continue;
    for (const Index k : event.samples)
      if (k < record.samples()) record.values(row, k) = std::numeric_limits<double>::quiet_NaN();
  }
  return record;
}

}  // namespace kalfem
