// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// What each stretch of a record says of one unknown by itself, in the filter's state: independent normal values.
struct StretchLevels {
  std::vector<Eigen::Index> end;    ///< sample behind each stretch
  Eigen::VectorXd value, variance;  ///< one a stretch
  Eigen::Index length = 1;          ///< samples of a stretch
  /// F statistic of two levels of the estimates at the ends of the stretches, and the first stretch of the second
  /// level: where states that a change left behind die out slowly, values are wrong by more than variances say,
  /// estimates less.
  double contrast = 0.0;
  Eigen::Index second_level = 0;
};

/// From a run that renews an unknown by `deviation` before each stretch: the estimate at its end is that before it,
/// with the renewal, and what the stretch adds,
///     1 / r = 1 / v_end - 1 / (v_begin + deviation^2),    y = r (m_end / v_end - m_begin / (v_begin + deviation^2)).
/// `row`: of the unknown in the state. Only stretches that end behind sample `first` and say anything.
StretchLevels levels_of(const EstimationResult& forgetting, Eigen::Index row, double deviation, Eigen::Index length,
                        Eigen::Index first);

/// How well one level, two levels, and a slow course explain the values: twice the rise of the log-likelihood over one
/// level, less ln(stretches) for each number that it takes [Schwarz 1978].
struct LevelFits {
  Eigen::Index place = 0;  ///< stretch within which the level changes; it belongs to neither
  double step = 0.0;       ///< of two levels
  double slow = 0.0;       ///< of the better of a random walk and a line
  /// Variance of the walk's steps from one stretch to the next at the largest likelihood.
  double walk = 0.0;
  /// Factor by which variances are too small, as neighbours differ: they say nothing of what the model misses.
  double scatter = 1.0;

  [[nodiscard]] bool is_slow() const { return slow > step; }
  [[nodiscard]] double best() const { return slow > step ? slow : step; }
};

LevelFits fits_of(const StretchLevels& levels);

/// The course of a random walk through the values, given all of them (Rauch, Tung and Striebel 1965).
struct WalkedCourse {
  Eigen::VectorXd value, deviation;
  double change_deviation = 0.0;  ///< of the difference between the two ends
};

/// `walk`: variance of its steps; variances of the values count `scatter` times.
WalkedCourse smoothed_walk(const StretchLevels& levels, double walk, double scatter);

}  // namespace kalfem
