#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

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
