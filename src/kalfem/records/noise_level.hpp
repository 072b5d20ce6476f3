// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Noise of smooth, well-sampled signals, seen in their third differences: these are small for the motion, and of
/// variance 20 sigma^2 for white noise of variance sigma^2 (1 + 9 + 9 + 1). Samples that are not finite are left out.

/// Standard deviation of each channel's noise over the whole record, from the median: a few jumps do not move it.
/// `values`: channels x samples. Zero for a channel without four finite samples in a row.
Eigen::ArrayXd noise_level(const Eigen::MatrixXd& values);

/// Where the noise of a record changes, and each channel's standard deviation on either side.
struct NoiseChange {
  Eigen::Index sample = 0;
  Eigen::ArrayXd before, after;
};

/// The sample that parts the record into two of different noise, at least `shortest` samples from either end: maximum
/// likelihood of two levels of log-power, summed over the channels. Every record has one; the levels say whether it
/// counts.
NoiseChange strongest_noise_change(const Eigen::MatrixXd& values, Eigen::Index shortest);

}  // namespace kalfem
