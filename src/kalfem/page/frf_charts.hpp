// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"

namespace kalfem {

/// One curve of a frequency response H on a chart.
struct FrfSeries {
  std::string label;
  Eigen::VectorXcd values;
  Role role = Role::other;
};

/// Words around the charts of a frequency response.
struct FrfChartWords {
  std::string id;     ///< of the chart: "frf-<id>" and "phase-<id>"
  std::string title;  ///< "acceleration at 2 per force at 1"
  std::string unit;   ///< "(m/s^2)/N"
};

/// Magnitude in decibel, one unit of the response being 0 dB, over frequency [Hz].
Chart magnitude_chart(const FrfChartWords& words, const Eigen::VectorXd& lines, const std::vector<FrfSeries>& series);
/// Phase [deg] in (-180, 180].
Chart phase_chart(const FrfChartWords& words, const Eigen::VectorXd& lines, const std::vector<FrfSeries>& series);

}  // namespace kalfem
