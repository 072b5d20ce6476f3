// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/sampled.hpp"
#include "system/small_systems.hpp"

namespace kalfem {

/// A damped oscillator m z'' + c z' + k z = F under free vibration and under a ramp F = rate t.
struct DampedOscillator {
  double m, c, k;

  [[nodiscard]] double omega() const { return std::sqrt(k / m); }
  [[nodiscard]] double zeta() const { return c / (2 * m * omega()); }
  /// Displacement and velocity a time t after (d, v), zeta < 1.
  [[nodiscard]] Eigen::Vector2d free(double d, double v, double t) const {
    const double decay = zeta() * omega(), damped = omega() * std::sqrt(1 - zeta() * zeta());
    const double b = (v + decay * d) / damped, e = std::exp(-decay * t), s = std::sin(damped * t),
                 o = std::cos(damped * t);
    return {e * (d * o + b * s), e * ((b * damped - decay * d) * o - (d * damped + decay * b) * s)};
  }
  /// From rest under F = rate t: the particular solution rate (t - c/k) / k and the free motion that starts it at rest.
  [[nodiscard]] Eigen::Vector2d ramp(double rate, double t) const {
    return Eigen::Vector2d(rate * (t - c / k) / k, rate / k) + free(rate * c / (k * k), -rate / k, t);
  }
};

/// Classical Runge-Kutta of m z'' = F(t) - c z' - k z - f(z, z') from (d, v), `steps` steps to the time T:
/// displacement, velocity. Shares nothing with the integrators under test.
template <typename Force, typename Law>
Eigen::Vector2d runge_kutta(const DampedOscillator& body, const Force& applied, const Law& law, double d, double v,
                            double T, int steps) {
  const auto acceleration = [&](double t, double d, double v) {
    return (applied(t) - body.c * v - body.k * d - law(d, v)) / body.m;
  };
  const double h = T / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const double v1 = v, a1 = acceleration(t, d, v1);
    const double v2 = v + h / 2 * a1, a2 = acceleration(t + h / 2, d + h / 2 * v1, v2);
    const double v3 = v + h / 2 * a2, a3 = acceleration(t + h / 2, d + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = acceleration(t + h, d + h * v3, v4);
    d += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {d, v};
}

inline SignalPtr straight_lines(const Eigen::VectorXd& samples, double sample_rate) {
  return make_sampled(
      samples, {.sample_rate = sample_rate, .interpolation = Interpolation::linear, .beyond = BeyondRecord::hold});
}

/// An undamped oscillator with a law beside its spring.
inline CoupledModel with_law(const ConnectorLawPtr& law) {
  return oscillator(1.0, 0.0, 1e3, {{"strut", "body.ground", "body.x", law, Eigen::VectorXd()}});
}

inline OutputMap displacement_of(const CoupledModel& model) {
  return make_outputs(model, {{"d", ObservedQuantity::displacement, {{"body.x", 1.0}}}});
}

inline InitialState start_at(double d, double v, Eigen::Index connector_states = 0) {
  auto state = at_rest(1, connector_states);
  state.displacement[0] = d;
  state.velocity[0] = v;
  return state;
}

}  // namespace kalfem
