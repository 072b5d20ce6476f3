// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

// A filter needs samples where there are none: in gaps and beyond the ends of a signal.

/// The signal with straight lines in place of missing samples (not a number); beyond the first and the last present
/// one they are constant. Zero where none is present.
Eigen::VectorXd without_gaps(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// The signal with `margin` more samples at either end, its reflection about its end points,
/// 2 x(0) - x(k) and 2 x(N-1) - x(N-1-k): value and slope go on. A margin of more than N - 1 samples repeats the last
/// of these.
Eigen::VectorXd reflected(const Eigen::VectorXd& signal, Eigen::Index margin);

/// One period of a periodic signal of 2^n samples: the signal, then a half cosine, of 64 samples or more, from its last
/// value to its first.
std::vector<double> periodic(const Eigen::VectorXd& signal);

}  // namespace kalfem
