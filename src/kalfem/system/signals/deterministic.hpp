// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// A transition from one value to another without a jump in value, rate or acceleration,
///     w(x) = 10 x^3 - 15 x^4 + 6 x^5,  x = (t - start) / duration clipped to [0, 1]:
/// a step, or with after = 0 the release of a load that was held.
struct StepOptions {
  double before = 0.0;    ///< value up to `start`
  double after = 1.0;     ///< value from `start + duration` on
  double start = 0.0;     ///< [s]
  double duration = 0.0;  ///< of the transition [s]; must be positive
};

IssueList validate(const StepOptions& options);
SignalPtr make_step(const StepOptions& options);

/// The same value at all times.
SignalPtr make_constant(double value);

/// signal * w((t - begin) / rise): zero with zero rate and acceleration at `begin`, the signal itself from begin + rise
/// on; derivatives by the product rule. A rise of 0 returns the signal unchanged (and not cut off before `begin`).
SignalPtr faded_in(SignalPtr signal, double rise, double begin = 0.0);

/// x * y with derivatives by the product rule.
SignalPtr product(SignalPtr x, SignalPtr y);

/// half_sine: amplitude sin(pi x), the usual model of a hammer blow; its rate jumps at both ends, and the second
///            derivative given is that between the jumps. For forces.
/// smooth:    amplitude sin^4(pi x); value and three derivatives vanish at both ends. For base displacements.
enum class PulseShape { half_sine, smooth };

/// One pulse over start <= t <= start + duration, x = (t - start) / duration; zero elsewhere.
/// Impulse (area): half_sine 2/pi, smooth 3/8 of amplitude * duration.
struct PulseOptions {
  double amplitude = 1.0;
  double start = 0.0;      ///< [s]
  double duration = 0.01;  ///< [s]
  PulseShape shape = PulseShape::half_sine;
  bool integrated_twice = false;  ///< the pulse is the second derivative of what is made, at rest before it
};

IssueList validate(const PulseOptions& options);
SignalPtr make_pulse(const PulseOptions& options);

/// amplitude * sin(2 pi frequency t + phase), at all times.
struct SineOptions {
  double amplitude = 1.0;
  double frequency = 1.0;         ///< [Hz]
  double phase = 0.0;             ///< [rad]
  double fade_in = 0.0;           ///< time of the smooth start from rest at t = 0 [s]; 0: none
  bool integrated_twice = false;  ///< the sine is the second derivative of what is made, which the fade-in acts on
};

IssueList validate(const SineOptions& options);
SignalPtr make_sine(const SineOptions& options);

enum class Sweep { linear, logarithmic };

/// Sine whose frequency runs from one value to another, up or down:
///     linear       f(t) = from + (to - from) t / duration
///     logarithmic  f(t) = from (to / from)^(t / duration)
/// x = amplitude sin(2 pi int_0^t f). Before 0 and after the duration the frequency stays at `from` and `to`, so the
/// second derivative jumps there and nothing else does.
struct SweptSineOptions {
  double amplitude = 1.0;
  double from = 1.0;       ///< [Hz]
  double to = 30.0;        ///< [Hz]
  double duration = 20.0;  ///< [s]
  Sweep sweep = Sweep::linear;
  double fade_in = 0.0;  ///< time of the smooth start from rest at t = 0 [s]; 0: none
};

IssueList validate(const SweptSineOptions& options);
SignalPtr make_swept_sine(const SweptSineOptions& options);

}  // namespace kalfem
