#include "kalfem/system/signals/random_signal.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/line_grid.hpp"
#include "kalfem/system/signals/smooth_step.hpp"
#include "kalfem/system/signals/spectral_lines.hpp"

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
  const auto frequencies = line_frequencies({options.lower, options.upper, options.duration});
  const double amplitude = options.rms * std::sqrt(2.0 / static_cast<double>(frequencies.size()));
  std::vector<SpectralLine> lines;
  for (const double frequency : frequencies)
    lines.push_back({amplitude, frequency, 2.0 * std::numbers::pi * stream.uniform()});
  return faded_in(make_spectral_lines(std::move(lines)), options.fade_in);
}

}  // namespace kalfem
