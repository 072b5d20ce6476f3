// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Modes that were measured at the points of a test, whoever identified them. What is not known is not a number, or
/// empty.
struct ModeSet {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  struct Mode {
    double frequency = unknown;      ///< undamped natural frequency [Hz]
    double frequency_std = unknown;  ///< [Hz]
    double damping = unknown;        ///< ratio to critical
    double damping_std = unknown;
    Eigen::VectorXcd shape = {};            ///< one a point, in any scale and phase; not a number: not measured
    Eigen::MatrixXd shape_covariance = {};  ///< of the real parts, then the imaginary ones, 2 points x 2 points
    double degrees_of_freedom = unknown;    ///< of the covariance: how well it is known
  };
  std::vector<std::string> points;         ///< of the shapes: names of channels, or node and direction, "12:+Z"
  std::vector<MeasuredPlace> places = {};  ///< of the points, as far as they are known; empty, or one a point
  std::vector<MeasuredNode> nodes = {};    ///< of the test's geometry, where there is one
  std::vector<Mode> modes = {};
};

/// How measured modes are taken as a comparison. Deviations that are given hold instead of those that the modes bring.
struct ModeSetOptions {
  std::optional<double> deviation = {};          ///< of a frequency, relative; none: that of the mode, or 1 %
  std::optional<double> shape_deviation = {};    ///< of an entry, relative to the largest; none: the covariance, or 5 %
  bool dampings = false;                         ///< compare damping ratios too
  std::optional<double> damping_deviation = {};  ///< relative; none: that of the mode, or 10 %
  double max_complexity = 0.25;                  ///< see RealShape; beyond, a shape is refused
};

/// The same modes at some of the points, in this order. "-a3" and "12:-Z" are those that look against a3 and 12:+Z.
/// Throws InvalidInput with every point that the set does not have.
ModeSet at_points(const ModeSet& set, const std::vector<std::string>& points);

}  // namespace kalfem
