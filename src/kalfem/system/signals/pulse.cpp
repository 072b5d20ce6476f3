#include "kalfem/system/signals/pulse.hpp"

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
    if (elapsed < 0.0 || elapsed > options_.duration) return {0.0, 0.0, 0.0};
    const double w = std::numbers::pi / options_.duration;
    const double s = std::sin(w * elapsed), c = std::cos(w * elapsed);
    const double height = options_.amplitude;
    if (options_.shape == PulseShape::half_sine) return {height * s, height * w * c, -height * w * w * s};
    return {height * s * s * s * s, height * 4.0 * w * s * s * s * c,
            height * 4.0 * w * w * s * s * (3.0 * c * c - s * s)};
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
