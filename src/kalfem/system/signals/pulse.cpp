#include "kalfem/system/signals/pulse.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

class Pulse final : public Signal {
public:
  explicit Pulse(const PulseOptions& options) : options_(options) {}

  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    check_sampling(start, step, count);
    SignalSamples samples = SignalSamples::Zero(count, 3);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double elapsed = start + static_cast<double>(k) * step - options_.start;
      if (elapsed >= 0.0 && elapsed <= options_.duration) samples.row(k) = options_.amplitude * inside(elapsed);
    }
    return samples;
  }

private:
  Eigen::Array<double, 1, 3> inside(double elapsed) const {
    const double w = std::numbers::pi / options_.duration;
    const double s = std::sin(w * elapsed);
    const double c = std::cos(w * elapsed);
    if (options_.shape == PulseShape::half_sine) return {s, w * c, -w * w * s};
    return {s * s * s * s, 4.0 * w * s * s * s * c, 4.0 * w * w * s * s * (3.0 * c * c - s * s)};
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
