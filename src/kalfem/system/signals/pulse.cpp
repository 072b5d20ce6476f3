#include "kalfem/system/signals/pulse.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

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

}  // namespace kalfem
