// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Two signals over frequency, by Welch's averages of Hann-windowed segments that overlap by half [Wel67].
struct SpectrumPair {
  Eigen::VectorXd lines;          ///< [Hz], without line 0
  Eigen::VectorXd first, second;  ///< one-sided densities [unit^2/Hz]
  Eigen::VectorXd difference;     ///< of first - second [unit^2/Hz]
  Eigen::VectorXd coherence;      ///< gamma^2 = |S_12|^2 / (S_11 S_22); 0 where either has no power
  Eigen::Index segments = 0;      ///< that were averaged: one alone has a coherence of 1
};

/// Of signals of the same length and rate. Segments in which a sample of either is missing (NaN) are left out; without
/// any segment everything is empty. `segment` [samples]: at least 4.
SpectrumPair spectrum_pair(const Eigen::VectorXd& first, const Eigen::VectorXd& second, double sample_rate,
                           Eigen::Index segment);

}  // namespace kalfem
