#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

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

}  // namespace kalfem
