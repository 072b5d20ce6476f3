// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/steps/estimation/outcome.hpp"

namespace kalfem {

/// How well a sensor agrees with the filter over a window of time, by the mean square of its standardised innovations.
enum class Agreement {
  green,
  amber,
  red,
  small,
  missing
};  ///< inside the 95 % band of chance, the 99.9 % band, larger than it, smaller than either; no data

/// What the filter expected of one sensor, and what came.
struct SensorCourse {
  /// `row`: of the filter's measurements.
  SensorCourse(const EstimationOutcome& outcome, Eigen::Index row);

  [[nodiscard]] bool has_innovations() const { return known > 0; }
  /// Root mean square of the standardised innovations after settling; 1 is expected.
  [[nodiscard]] double size() const;
  /// Share of the innovations after settling in their 95 % band.
  [[nodiscard]] double inside_95() const;
  /// Share of the windows after settling with that agreement, of those with data; 0 where none has any.
  [[nodiscard]] double share(Agreement agreement) const;
  /// Time in the middle of the window whose innovations are the largest [s].
  [[nodiscard]] double worst_time() const;

  std::string name, unit;
  Eigen::VectorXd measured, innovation, deviation;
  Eigen::VectorXd expected;        ///< one sample ahead
  Eigen::VectorXd settled;         ///< innovations after settling, in their expected deviations
  Eigen::Index known = 0;          ///< of these, that are not missing
  std::vector<Agreement> windows;  ///< after settling, of equal length
  Eigen::VectorXd window_size;     ///< mean square of each, not a number without data
  double window_length = 0.0;      ///< [s]
  double settled_at = 0.0;         ///< [s]
};

/// rho(k) of k = 0 to `lags` over the pairs of samples that are both there; empty where there are fewer than four times
/// as many samples.
std::vector<double> correlogram(const Eigen::VectorXd& sequence, Eigen::Index lags);

/// rho(k) = sum a_j b_{j-k} / sqrt(sum a^2 sum b^2) of k = 0 to `lags`: how much of `a` repeats what `b` did before.
/// Both about their means; empty as above, or where either does not move.
std::vector<double> cross_correlogram(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index lags);

/// The agreement of a sensor over time as a strip of bars: low and green inside the 95 % band of chance, higher and
/// amber, full and red above the 99.9 % band; blue below the 95 % band, where the noise is stated too large. A mark at
/// the worst window leads to the chart `chart_id` at that time.
std::string agreement_strip_svg(const SensorCourse& sensor, const std::string& chart_id);

}  // namespace kalfem
