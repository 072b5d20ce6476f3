// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/deterministic.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/line_series.hpp"

namespace kalfem {

namespace {

// From one level to another by 10 x^3 - 15 x^4 + 6 x^5, whose first and second derivatives vanish at both ends: inputs
// need two derivatives.
class Step final : public FormulaSignal {
public:
  explicit Step(const StepOptions& options) : options_(options) {}

private:
  Eigen::Array<double, 1, 3> at(double time) const override {
    const double T = options_.duration;
    const double x = std::clamp((time - options_.start) / T, 0.0, 1.0);
    const double height = options_.after - options_.before;
    return {options_.before + height * x * x * x * (10.0 + x * (-15.0 + 6.0 * x)),
            height / T * 30.0 * x * x * (1.0 - x) * (1.0 - x),
            height / (T * T) * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)};
  }

  StepOptions options_;
};

class Constant final : public Signal {
public:
  explicit Constant(double value) : value_(value) {}
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    check_sampling(start, step, count);
    SignalSamples samples = SignalSamples::Zero(count, 3);
    samples.col(0) = value_;
    return samples;
  }

private:
  double value_;
};

/// Derivatives by the product rule.
class Product final : public Signal {
public:
  Product(SignalPtr x, SignalPtr y) : x_(std::move(x)), y_(std::move(y)) {}
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    const SignalSamples x = x_->sample(start, step, count);
    const SignalSamples y = y_->sample(start, step, count);
    SignalSamples xy(count, 3);
    xy.col(0) = x.col(0) * y.col(0);
    xy.col(1) = x.col(1) * y.col(0) + x.col(0) * y.col(1);
    xy.col(2) = x.col(2) * y.col(0) + 2.0 * x.col(1) * y.col(1) + x.col(0) * y.col(2);
    return xy;
  }
  bool covers(double begin, double end) const override { return x_->covers(begin, end) && y_->covers(begin, end); }
  double determined_until() const override { return std::min(x_->determined_until(), y_->determined_until()); }

private:
  SignalPtr x_;
  SignalPtr y_;
};

}  // namespace

IssueList validate(const StepOptions& options) {
  IssueList issues;
  require_finite(issues, "step: before", options.before);
  require_finite(issues, "step: after", options.after);
  require_finite(issues, "step: start [s]", options.start);
  require_positive(issues, "step: duration of the transition [s]", options.duration);
  return issues;
}

SignalPtr make_step(const StepOptions& options) {
  validate(options).raise();
  return std::make_shared<Step>(options);
}

SignalPtr make_constant(double value) {
  IssueList issues;
  require_finite(issues, "constant signal: value", value);
  issues.raise();
  return std::make_shared<Constant>(value);
}

SignalPtr product(SignalPtr x, SignalPtr y) {
  if (!x || !y) throw InvalidInput("a signal is missing (null pointer)", "a product needs two signals", "");
  return std::make_shared<Product>(std::move(x), std::move(y));
}

// The fade is a step from 0 to 1 as a factor: the product rule gives the derivatives, so the start is at rest.
SignalPtr faded_in(SignalPtr signal, double rise, double begin) {
  IssueList issues;
  require_nonnegative(issues, "fade-in [s]", rise);
  issues.raise();
  if (rise == 0.0) return signal;
  return product(std::move(signal), make_step({.before = 0.0, .after = 1.0, .start = begin, .duration = rise}));
}

namespace {

class Pulse final : public FormulaSignal {
public:
  explicit Pulse(const PulseOptions& options) : options_(options) {}

private:
  Eigen::Array<double, 1, 3> at(double time) const override {
    const double elapsed = time - options_.start;
    if (options_.integrated_twice) return integral_at(elapsed);
    if (elapsed < 0.0 || elapsed > options_.duration) return {0.0, 0.0, 0.0};
    const double w = std::numbers::pi / options_.duration;
    const double s = std::sin(w * elapsed), c = std::cos(w * elapsed);
    const double height = options_.amplitude;
    if (options_.shape == PulseShape::half_sine) return {height * s, height * w * c, -height * w * w * s};
    return {height * s * s * s * s, height * 4.0 * w * s * s * s * c,
            height * 4.0 * w * w * s * s * (3.0 * c * c - s * s)};
  }

  // The double integral of the pulse in closed form, from rest. Afterwards the speed gained stays, as momentum does.
  /// The displacement of which the pulse is the acceleration; after it the speed stays.
  Eigen::Array<double, 1, 3> integral_at(double elapsed) const {
    if (elapsed < 0.0) return {0.0, 0.0, 0.0};
    const double w = std::numbers::pi / options_.duration, height = options_.amplitude;
    const double inside = std::min(elapsed, options_.duration), x = w * inside, s = std::sin(x);
    Eigen::Array<double, 1, 3> motion;
    if (options_.shape == PulseShape::half_sine)
      motion << height / (w * w) * (x - s), height / w * (1.0 - std::cos(x)), height * s;
    else
      motion << height / (w * w) * (3.0 / 16.0 * x * x + (16.0 * std::cos(2.0 * x) - std::cos(4.0 * x) - 15.0) / 128.0),
          height / w * (3.0 / 8.0 * x - std::sin(2.0 * x) / 4.0 + std::sin(4.0 * x) / 32.0), height * s * s * s * s;
    if (elapsed > inside) {
      motion[0] += (elapsed - inside) * motion[1];
      motion[2] = 0.0;
    }
    return motion;
  }

  PulseOptions options_;
};

}  // namespace

IssueList validate(const PulseOptions& options) {
  IssueList issues;
  require_finite(issues, "pulse: amplitude", options.amplitude);
  require_finite(issues, "pulse: start [s]", options.start);
  require_positive(issues, "pulse: duration [s]", options.duration);
  return issues;
}

SignalPtr make_pulse(const PulseOptions& options) {
  validate(options).raise();
  return std::make_shared<Pulse>(options);
}

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

  // expm1 keeps the digits of a slow logarithmic sweep, whose growth times t is small.
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

// Twice integrated, a sine is a sine again, so only its amplitude changes; the fade-in then acts on the displacement
// and starts it from rest.
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
