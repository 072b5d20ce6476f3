#include "kalfem/system/signals/random_signal.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/line_grid.hpp"
#include "kalfem/system/signals/line_series.hpp"
#include "kalfem/system/signals/smooth_step.hpp"

namespace kalfem {

IssueList validate(const RandomSignalOptions& options) {
  IssueList issues;
  require_nonnegative(issues, "random signal: rms", options.rms);
  require_band(issues, "random signal: band [Hz]", options.lower, options.upper);
  require_positive(issues, "random signal: duration [s]", options.duration);
  require_nonnegative(issues, "random signal: fade_in [s]", options.fade_in);
  if (options.fade_in > options.duration)
    issues.add({},
               "random signal: fade_in is " + shown(options.fade_in) + " s, longer than the duration of " +
                   shown(options.duration) + " s",
               "the signal would never reach its rms");
  if (issues.empty()) require_lines(issues, "random signal", {options.lower, options.upper, options.duration});
  return issues;
}

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

}  // namespace kalfem
