// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The samples of a velocity that are integrated.
struct VelocitySamples {
  double start = 0.0;        ///< time of the first one [s]
  double sample_rate = 1.0;  ///< [Hz]
  Eigen::Index count = 2;    ///< at least two
};

/// A displacement r with r' the given velocity, which is a spline through samples (make_sampled()); it is integrated
/// exactly. A geophone tells neither the displacement at its start nor its own offset: the straight line that fits the
/// displacement best is taken out, by least squares weighted with a Hann window. It hardly sees a motion that swings
/// about its rest many times. Known where the samples are.
SignalPtr integrated_velocity(SignalPtr velocity, const VelocitySamples& samples);

}  // namespace kalfem
