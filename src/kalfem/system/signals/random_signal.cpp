// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/random_signal.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/line_series.hpp"

namespace kalfem {

namespace {

constexpr double most_lines = 2e6;       ///< about 100 bytes each
constexpr double edge_tolerance = 1e-9;  // of a line spacing: an edge that is a multiple but for rounding belongs to it

double lowest_line(const LineGrid& grid) { return std::ceil(grid.lower * grid.duration - edge_tolerance); }
double last_line(const LineGrid& grid) { return std::floor(grid.upper * grid.duration + edge_tolerance); }

}  // namespace

// The number of lines is computed as a double: a tiny spacing must be refused before it overflows an integer.
void require_lines(IssueList& issues, const std::string& signal, const LineGrid& grid) {
  const double count = last_line(grid) - lowest_line(grid) + 1.0;
  const std::string band = "[" + to_string(grid.lower) + ", " + to_string(grid.upper) + "] Hz";
  if (!(count >= 1.0))
    issues.add({}, signal + ": no multiple of 1/duration = " + to_string(1.0 / grid.duration) + " Hz lies in " + band,
               "the signal is a sum of lines with this spacing", "widen the band or lengthen the duration");
  if (count > most_lines)
    issues.add({},
               signal + ": " + band + " over " + to_string(grid.duration) + " s needs " + to_string(count) + " lines",
               "at most " + to_string(most_lines) + " can be computed", "narrow the band or shorten the duration");
}

std::int64_t first_line(const LineGrid& grid) { return static_cast<std::int64_t>(lowest_line(grid)); }

// Line over duration, not a running sum of spacings: the last of a million lines has the frequency of its number.
std::vector<double> line_frequencies(const LineGrid& grid) {
  std::vector<double> frequencies;
  for (double line = lowest_line(grid); line <= last_line(grid); ++line) frequencies.push_back(line / grid.duration);
  return frequencies;
}

IssueList validate(const RandomSignalOptions& options) {
  IssueList issues;
  require_nonnegative(issues, "random signal: rms", options.rms);
  require_band(issues, "random signal: band [Hz]", options.lower, options.upper);
  require_positive(issues, "random signal: duration [s]", options.duration);
  require_nonnegative(issues, "random signal: fade_in [s]", options.fade_in);
  if (options.fade_in > options.duration)
    issues.add({},
               "random signal: fade_in is " + to_string(options.fade_in) + " s, longer than the duration of " +
                   to_string(options.duration) + " s",
               "the signal would never reach its rms");
  if (issues.empty()) require_lines(issues, "random signal", {options.lower, options.upper, options.duration});
  return issues;
}

// A sum of harmonics of equal amplitude at all multiples of 1 / duration in the band, with random phases: its rms is
// that of the amplitudes, exactly, and its spectrum is flat. The phases come from the stream of the signal's own name,
// so that a second signal changes nothing in the first. Integration twice divides each amplitude by -w^2.
SignalPtr make_random(const RandomSignalOptions& options) {
  validate(options).raise();
  RandomStream stream(options.seed, options.name);
  const LineGrid grid{options.lower, options.upper, options.duration};
  const auto frequencies = line_frequencies(grid);
  const auto lines = frequencies.size();
  LineSeries series{options.duration, first_line(grid), {}, {}};
  series.amplitude.assign(lines, options.rms * std::sqrt(2.0 / static_cast<double>(lines)));
  for (std::size_t l = 0; l < lines; ++l) series.phase.push_back(2.0 * std::numbers::pi * stream.uniform());
  if (options.integrated_twice)
    for (std::size_t l = 0; l < lines; ++l)
      series.amplitude[l] = amplitude_integrated_twice(series.amplitude[l], frequencies[l]);
  return faded_in(make_line_series(std::move(series)), options.fade_in);
}

namespace {

/// The band of temporal frequencies f = n v.
LineGrid temporal_lines(const RoadProfileOptions& options) {
  return {options.lower * options.speed, options.upper * options.speed, options.duration};
}

}  // namespace

double road_spectrum(char road_class, double spatial_frequency) {
  constexpr double reference_frequency = 0.1;  // n0 [cycles/m]
  const double reference = 16e-6 * std::pow(4.0, road_class - 'A');
  return reference * std::pow(spatial_frequency / reference_frequency, -2.0);
}

IssueList validate(const RoadProfileOptions& options) {
  IssueList issues;
  if (options.road_class < 'A' || options.road_class > 'H')
    issues.add({}, std::string("road profile: class is '") + options.road_class + "'", "ISO 8608 defines A to H",
               "write one capital letter from A (very good) to H");
  require_positive(issues, "road profile: speed [m/s]", options.speed);
  require_band(issues, "road profile: band [cycles/m]", options.lower, options.upper);
  require_positive(issues, "road profile: duration [s]", options.duration);
  require_nonnegative(issues, "road profile: fade_in [s]", options.fade_in);
  if (issues.empty()) require_lines(issues, "road profile", temporal_lines(options));
  return issues;
}

// The same sum over the lines of the moving wheel, f = n v. Each takes the part Gd(n) dn of the variance, as the
// one-sided spectrum says, so amplitudes fall with 1 / n.
SignalPtr make_road_profile(const RoadProfileOptions& options) {
  validate(options).raise();
  RandomStream stream(options.seed, options.name);
  const double spacing = 1.0 / (options.speed * options.duration);
  const LineGrid grid = temporal_lines(options);
  LineSeries series{options.duration, first_line(grid), {}, {}};
  for (const double frequency : line_frequencies(grid)) {
    series.amplitude.push_back(std::sqrt(2.0 * road_spectrum(options.road_class, frequency / options.speed) * spacing));
    series.phase.push_back(2.0 * std::numbers::pi * stream.uniform());
  }
  return faded_in(make_line_series(std::move(series)), options.fade_in);
}

}  // namespace kalfem
