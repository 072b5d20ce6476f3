#include "kalfem/system/signals/harmonic.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/line_series.hpp"
#include "kalfem/system/signals/transients.hpp"

namespace kalfem {

namespace {

// The phase is integrated in closed form: f(t) = f_0 + (f_1 - f_0) t / T linearly, f_0 (f_1 / f_0)^(t / T)
// logarithmically. Outside its duration the frequency stands still. sin and cos are taken of the fraction of a cycle,
// so that long sweeps lose no digits.
class SweptSine final : public FormulaSignal {
public:
  explicit SweptSine(const SweptSineOptions& options) : options_(options) {}

private:
  /// Turned cycles, frequency [Hz] and its rate [Hz/s].
  struct Phase {
    double cycles, frequency, rate;
  };

  Phase swept(double t) const {
    const auto& [amplitude, from, to, T, sweep, fade_in] = options_;
    if (sweep == Sweep::linear || from == to) {
      const double rate = (to - from) / T;
      return {t * (from + 0.5 * rate * t), from + rate * t, rate};
    }
    const double growth = std::log(to / from) / T;
    return {from * std::expm1(growth * t) / growth, from * std::exp(growth * t), growth * from * std::exp(growth * t)};
  }

  Phase phase(double time) const {
    const double inside = std::clamp(time, 0.0, options_.duration);
    Phase p = swept(inside);
    if (inside != time) p = {p.cycles + p.frequency * (time - inside), p.frequency, 0.0};
    return p;
  }

  Eigen::Array<double, 1, 3> at(double time) const override {
    constexpr double turn = 2.0 * std::numbers::pi;
    const auto [cycles, frequency, rate] = phase(time);
    const double s = options_.amplitude * std::sin(turn * (cycles - std::round(cycles)));
    const double c = options_.amplitude * std::cos(turn * (cycles - std::round(cycles)));
    const double w = turn * frequency;
    return {s, w * c, turn * rate * c - w * w * s};
  }

  SweptSineOptions options_;
};

}  // namespace

IssueList validate(const SineOptions& options) {
  IssueList issues;
  require_finite(issues, "sine: amplitude", options.amplitude);
  require_positive(issues, "sine: frequency [Hz]", options.frequency);
  require_finite(issues, "sine: phase [rad]", options.phase);
  require_nonnegative(issues, "sine: fade_in [s]", options.fade_in);
  return issues;
}

SignalPtr make_sine(const SineOptions& options) {
  validate(options).raise();
  const double amplitude =
      options.integrated_twice ? amplitude_integrated_twice(options.amplitude, options.frequency) : options.amplitude;
  return faded_in(make_spectral_lines({{amplitude, options.frequency, options.phase}}), options.fade_in);
}

IssueList validate(const SweptSineOptions& options) {
  IssueList issues;
  require_finite(issues, "swept sine: amplitude", options.amplitude);
  require_positive(issues, "swept sine: from [Hz]", options.from);
  require_positive(issues, "swept sine: to [Hz]", options.to);
  require_positive(issues, "swept sine: duration [s]", options.duration);
  require_nonnegative(issues, "swept sine: fade_in [s]", options.fade_in);
  return issues;
}

SignalPtr make_swept_sine(const SweptSineOptions& options) {
  validate(options).raise();
  return faded_in(std::make_shared<SweptSine>(options), options.fade_in);
}

}  // namespace kalfem
