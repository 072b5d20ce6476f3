// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A Butterworth filter without phase: its gain at the frequency f is
///     1 / sqrt(1 + (high_pass / f)^(2 order)) / sqrt(1 + (f / low_pass)^(2 order)),
/// -3 dB at either limit. What a causal filter would shift in time stays where it is.
struct ZeroPhaseFilter {
  double high_pass = 0.0;  ///< [Hz]; 0: none
  double low_pass = 0.0;   ///< [Hz]; 0: none
  int order = 4;
};

/// Filters an equally sampled signal by its discrete Fourier transform. Its ends are reflected, over three periods of
/// the lowest limit as far as the signal is that long; within about one period of an end the answer depends on this
/// continuation. Missing samples are bridged by straight lines and are missing afterwards.
Eigen::VectorXd filtered(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate,
                         const ZeroPhaseFilter& filter);

}  // namespace kalfem
