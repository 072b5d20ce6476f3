#include "kalfem/system/signals/road_profile.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/line_grid.hpp"
#include "kalfem/system/signals/line_series.hpp"
#include "kalfem/system/signals/smooth_step.hpp"

namespace kalfem {

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
    issues.add({}, std::string("road profile: class is '") + options.road_class + "'", "ISO 8608 knows A to H",
               "write one capital letter from A (very good) to H");
  require_positive(issues, "road profile: speed [m/s]", options.speed);
  require_band(issues, "road profile: band [cycles/m]", options.lower, options.upper);
  require_positive(issues, "road profile: duration [s]", options.duration);
  require_nonnegative(issues, "road profile: fade_in [s]", options.fade_in);
  if (issues.empty()) require_lines(issues, "road profile", temporal_lines(options));
  return issues;
}

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
