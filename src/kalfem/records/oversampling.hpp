// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>

namespace kalfem {

/// Part of a signal's variance above a quarter of its sampling rate, by its Hann-windowed spectrum; 0 for a constant.
/// There a cubic spline through the samples is wrong: by 0.7 % at a fifth of the rate, 3 % at 0.3 and 16 % at 0.4.
double share_above_quarter(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// Whether a spline through the samples loses part of the signal: of 8 samples or more, over a thousandth of the
/// variance lies above a quarter of the rate.
bool needs_oversampling(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// That part in words: "12 % of its variance lies above 25 Hz, a quarter of its sampling rate".
std::string fast_content(double share, double sample_rate);

/// The signal at `factor` times its sampling rate, as if it held no frequency above half of that: factor (N - 1) + 1
/// samples, of which every factor-th one is a given one. The kernel is a sinc with a Kaiser window over 32 samples at
/// either side: content up to 0.45 of the rate is right to 1e-5 [Kai74]. The ends are reflected
/// (signal_continuation.hpp).
Eigen::VectorXd oversampled(const Eigen::Ref<const Eigen::VectorXd>& signal, Eigen::Index factor);

}  // namespace kalfem
