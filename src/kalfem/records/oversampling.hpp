// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>

namespace kalfem {

/// Part of a signal's variance above a quarter of its sampling rate, by its Hann-windowed spectrum; 0 for a constant.
/// There a cubic spline through the samples is wrong: by 0.7 % at a fifth of the rate, 3 % at 0.3 and 16 % at 0.4.
double share_above_quarter(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// Whether so much lies there that it is told: over a thousandth of the variance, of 32 samples or more.
bool is_fast(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// What a cubic spline through the samples takes from the signal, as a part of its rms. Of content at the part f of the
/// sampling rate it takes about e = (f / (1 - f))^4 + (f / (1 + f))^4, and shows as much at images of it (Unser 1999,
/// IEEE Signal Processing Magazine 16(6), 22-38):
///     sqrt(sum S(f) e(f)^2 / sum S(f)).
/// 0 for fewer than 32 samples.
double spline_error(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// That part in words: "12 % of its variance lies above 25 Hz, a quarter of its sampling rate".
std::string fast_content(double share, double sample_rate);

/// The signal at `factor` times its sampling rate, as if it held no frequency above half of that: factor (N - 1) + 1
/// samples, of which every factor-th one is a given one. The kernel is a sinc with a Kaiser window over 32 samples at
/// either side: content up to 0.45 of the rate is right to 1e-5 [Kai74]. The ends are reflected
/// (signal_continuation.hpp).
Eigen::VectorXd oversampled(const Eigen::Ref<const Eigen::VectorXd>& signal, Eigen::Index factor);

/// Intervals at the signal's end between whose samples oversampled() may be wrong by more than a thousandth of the
/// signal's rms about its mean, as the samples that would follow are missing: of noise up to half the rate about 22, of
/// a signal that has died away none.
Eigen::Index undetermined_samples(const Eigen::Ref<const Eigen::VectorXd>& signal);

}  // namespace kalfem
