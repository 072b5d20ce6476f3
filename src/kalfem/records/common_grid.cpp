// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/common_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double largest_shift = 0.1;  ///< of the shortest usual interval
constexpr int most_refinement = 10;
constexpr double rounding = 1e-6;

/// The rate at which uneven times count: whole numbers of intervals lie between them as far as they can tell.
double fitted_rate(const VectorXd& times) {
  double rate = 1.0 / typical_interval(times), intervals = 0.0;
  for (Index k = 1; k < times.size(); ++k) intervals += std::max(1.0, std::round((times[k] - times[k - 1]) * rate));
  const double span = times[times.size() - 1] - times[0];
  rate = intervals / span;
  return roundest(rate, rate * largest_shift / intervals);
}

double rate_of(const SampleTimes& channel) {
  if (channel.times.size() > 1) return fitted_rate(channel.times);
  return channel.interval > 0.0 ? 1.0 / channel.interval : 0.0;
}

/// How far a grid is from the samples of a channel [s]; nothing where two of them share a time.
std::optional<std::pair<double, double>> shifts(const SampleTimes& channel, double start, double rate) {
  double lowest = 0.0, highest = 0.0, before = -std::numeric_limits<double>::infinity();
  for (Index k = 0; k < channel.count; ++k) {
    const double time = channel.at(k), place = std::round((time - start) * rate);
    if (place <= before) return std::nullopt;
    before = place;
    const double shift = time - start - place / rate;
    lowest = std::min(lowest, shift);
    highest = std::max(highest, shift);
  }
  return std::pair{lowest, highest};
}

/// Largest shift of a sample; nothing where two samples of a channel share a time.
std::optional<double> largest_of(const std::vector<SampleTimes>& channels, double start, double rate) {
  double largest = 0.0;
  for (const auto& channel : channels) {
    const auto own = shifts(channel, start, rate);
    if (!own) return std::nullopt;
    largest = std::max({largest, -own->first, own->second});
  }
  return largest;
}

}  // namespace

double SampleTimes::usual_interval() const { return times.size() > 1 ? typical_interval(times) : interval; }

// The grid starts with the fastest channel, in the middle of its samples' shifts; channels that begin earlier move the
// start by whole grid intervals.
CommonGrid common_grid(const std::vector<SampleTimes>& channels) {
  const auto& fastest = *std::ranges::max_element(channels, {}, rate_of);
  const double base = rate_of(fastest);
  double start = fastest.at(0);
  if (const auto own = shifts(fastest, start, base); own && fastest.times.size() > 1)
    start += 0.5 * (own->first + own->second);
  for (int refinement = 1; refinement <= most_refinement; ++refinement) {
    const double rate = base * refinement;
    const auto largest = largest_of(channels, start, rate);
    if (!largest || *largest * base > largest_shift + rounding) continue;
    double first = 0.0, last = 0.0;
    for (const auto& channel : channels) {
      first = std::min(first, std::round((channel.at(0) - start) * rate));
      last = std::max(last, std::round((channel.end() - start) * rate));
    }
    return {.start = start + first / rate, .sample_rate = rate, .last = last - first, .largest_shift = *largest};
  }
  throw InvalidInput(Issue{{},
                           "two samples of one channel lie closer than a twentieth of its usual interval",
                           "the filter needs a time of its own for each",
                           "remove one of the two, or resample the record to equal intervals"});
}

std::vector<Index> places_on(const CommonGrid& grid, const SampleTimes& channel) {
  std::vector<Index> places;
  places.reserve(static_cast<std::size_t>(channel.count));
  for (Index k = 0; k < channel.count; ++k)
    places.push_back(static_cast<Index>(std::llround((channel.at(k) - grid.start) * grid.sample_rate)));
  return places;
}

namespace {

/// Second derivatives at the knots of the natural spline: a tridiagonal system, solved from the first to the last.
VectorXd curvatures(const VectorXd& t, const VectorXd& y) {
  const Index n = t.size();
  VectorXd m = VectorXd::Zero(n), ratio = VectorXd::Zero(n);
  for (Index k = 1; k + 1 < n; ++k) {
    const double before = t[k] - t[k - 1], after = t[k + 1] - t[k];
    const double right = 6.0 * ((y[k + 1] - y[k]) / after - (y[k] - y[k - 1]) / before);
    const double pivot = 2.0 * (before + after) - before * ratio[k - 1];
    ratio[k] = after / pivot;
    m[k] = (right - before * m[k - 1]) / pivot;
  }
  for (Index k = n - 2; k > 0; --k) m[k] -= ratio[k] * m[k + 1];
  return m;
}

}  // namespace

VectorXd evenly_interpolated(const SampleTimes& channel, const Eigen::Ref<const VectorXd>& values, double sample_rate) {
  VectorXd t(channel.count);
  for (Index k = 0; k < channel.count; ++k) t[k] = channel.at(k);
  const VectorXd m = curvatures(t, values);
  const auto samples = static_cast<Index>(std::floor((channel.end() - t[0]) * sample_rate * (1.0 + 1e-12))) + 1;
  VectorXd even(samples);
  for (Index j = 0, k = 0; j < samples; ++j) {
    const double time = t[0] + static_cast<double>(j) / sample_rate;
    while (k + 2 < channel.count && time > t[k + 1]) ++k;
    const double h = t[k + 1] - t[k], a = (t[k + 1] - time) / h, b = 1.0 - a;
    even[j] = a * values[k] + b * values[k + 1] + ((a * a * a - a) * m[k] + (b * b * b - b) * m[k + 1]) * h * h / 6.0;
  }
  return even;
}

}  // namespace kalfem
