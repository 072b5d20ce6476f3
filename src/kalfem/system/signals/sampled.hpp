// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// cubic:  not-a-knot spline: twice continuously differentiable, value of order 4, rate of order 3, acceleration of
///         order 2 in the sampling interval, up to the ends. Three samples give a parabola, two a line. Samples of
///         which a spline would take more than 1e-4 (spline_error()) are oversampled first, as a band-limited signal
///         (oversampled(), four times): it takes 0.4 % at 0.2 of the rate, 3 % at 0.3 and 16 % at 0.4.
/// linear: straight between the samples; the rate is the segment's slope (of the segment that begins there, at a
///         sample), the second derivative zero.
enum class Interpolation { cubic, linear };

/// What holds before the first and after the last sample: sample() throws, or the end value stays with zero
/// derivatives.
enum class BeyondRecord { reject, hold };

/// A measured column with its own sampling rate as a function of time.
struct SampledOptions {
  double sample_rate = 1.0;  ///< [Hz]
  double start = 0.0;        ///< time of the first sample [s]
  Interpolation interpolation = Interpolation::cubic;
  BeyondRecord beyond = BeyondRecord::reject;
};

IssueList validate(const SampledOptions& options);

/// Throws InvalidInput for fewer than two samples or one that is not finite.
SignalPtr make_sampled(Eigen::VectorXd values, const SampledOptions& options);

}  // namespace kalfem
