// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// The part of a posterior about one of its maxima.
struct PosteriorMode {
  double weight = 1.0;              ///< of all modes' sum [-]
  Eigen::VectorXd peak;             ///< theta at the maximum, p
  Eigen::VectorXd mean, deviation;  ///< of theta in this part, p
};

/// Parts below this weight are not told as modes.
inline constexpr double least_mode_weight = 0.01;

/// The modes that a reader can tell apart, the heaviest first: two whose means lie within two deviations of each other
/// in every parameter are one, with the weight, mean and deviation of both and the peak of the heavier. A search ends
/// twice on one ridge where a sum of parameters is known a hundred times better than each.
std::vector<PosteriorMode> told_apart(std::vector<PosteriorMode> modes);

}  // namespace kalfem
