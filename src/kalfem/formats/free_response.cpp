#include "kalfem/formats/free_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/noise_level.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check(const TimeSeries& record, const FreeResponseOptions& options) {
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
               "it is a part of the largest excursion below 0.5");
  if (options.samples < 1) issues.add({}, "samples is " + std::to_string(options.samples), "it must be at least 1");
  issues.raise();
}

/// Mean, standard deviation and range of the finite samples of each channel.
struct Spread {
  ArrayXd mean, deviation, range;
};

Spread spread(const MatrixXd& values, Index from, Index count) {
  const Index channels = values.cols();
  Spread result{ArrayXd::Zero(channels), ArrayXd::Zero(channels), ArrayXd::Zero(channels)};
  for (Index c = 0; c < channels; ++c) {
    const ArrayXd part = values.col(c).segment(from, count).array();
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
ArrayXd allowed_departure(const TimeSeries& record, const ArrayXd& noise, const FreeResponseOptions& options) {
  const ArrayXd excursion = spread(record.values, 0, record.samples()).range;
  return (options.departure * excursion).max(options.noise_factor * noise);
}

bool away(const TimeSeries& record, Index sample, const ArrayXd& position, const ArrayXd& allowed) {
  return ((record.values.row(sample).transpose().array() - position).abs() > allowed).any();  // false for NaN
}

Index length_in_samples(const TimeSeries& record, double seconds) {
  return std::max<Index>(2, std::llround(std::min(seconds * record.sample_rate, 1e12)));
}

/// First and last sample of the longest run of windows that stand still, if there is one.
std::optional<std::pair<Index, Index>> longest_standstill(const TimeSeries& record, Index from, Index window,
                                                          const ArrayXd& allowed) {
  std::optional<std::pair<Index, Index>> longest, run;
  for (Index k = from; k + window <= record.samples(); ++k) {
    const bool still = (spread(record.values, k, window).range <= 2.0 * allowed).all();
    if (!still) {
      run.reset();
      continue;
    }
    run = {run ? run->first : k, k + window - 1};
    if (!longest || run->second - run->first > longest->second - longest->first) longest = run;
  }
  return longest;
}

}  // namespace

std::optional<Release> find_release(const TimeSeries& record, const FreeResponseOptions& options) {
  check(record, options);
  const Index hold = length_in_samples(record, options.hold), n = record.samples();
  if (n < hold + options.samples) return std::nullopt;
  const Spread held = spread(record.values, 0, hold);
  const ArrayXd allowed = allowed_departure(record, held.deviation, options);
  // A channel that only makes noise would pass as held; one that moves in the hold does not.
  if ((held.range > 2.0 * allowed).any()) return std::nullopt;
  Index in_a_row = 0;
  for (Index k = 0; k < n; ++k) {
    in_a_row = away(record, k, held.mean, allowed) ? in_a_row + 1 : 0;
    if (in_a_row < options.samples) continue;
    const Index sample = k - options.samples + 1;
    if (sample < hold) return std::nullopt;
    return Release{sample, record.time(sample), spread(record.values, 0, hold).mean.matrix()};
  }
  return std::nullopt;
}

std::optional<Rest> find_rest(const TimeSeries& record, Index from, const FreeResponseOptions& options) {
  check(record, options);
  if (from < 0 || from >= record.samples())
    throw InvalidInput("sample " + std::to_string(from) + " is outside the record",
                       "it has " + std::to_string(record.samples()) + " samples", "give a sample of the record");
  const Index window = length_in_samples(record, options.still);
  if (from + window > record.samples()) return std::nullopt;
  const ArrayXd allowed = allowed_departure(record, noise_level(record.values), options);
  const auto standstill = longest_standstill(record, from, window, allowed);
  if (!standstill) return std::nullopt;
  const auto [first, last] = *standstill;
  const Index settled = (first + last) / 2;  // by its second half creeping and small oscillations have ended
  const Spread rest = spread(record.values, settled, last - settled + 1);
  Index end = from;
  for (Index k = from; k < settled; ++k)
    if (away(record, k, rest.mean, allowed)) end = k;
  return Rest{end, last, record.time(end), rest.mean.matrix(), rest.deviation.matrix()};
}

}  // namespace kalfem
