#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/time_series.hpp"

namespace kalfem {

/// What was found of a free response and taken off its record.
struct FreeResponseFound {
  double release = 0.0;        ///< time in the file [s]
  std::optional<double> rest;  ///< time in the file from which the structure is at rest [s]; nothing: it never is
  Eigen::VectorXd position;   ///< that was taken off each channel: where it rests, or else the middle of its last swing
  Eigen::VectorXd deviation;  ///< prior standard deviation of the rest position about it; empty: it is known

  [[nodiscard]] bool rest_is_unknown() const { return deviation.size() > 0; }
};

/// The measured record of a case, cut and prepared as it asks.
struct MeasuredRecord {
  TimeSeries series;                     ///< one channel a sensor, SI; start is the time in the file
  std::vector<std::string> preparation;  ///< what was done to it, in words
  Eigen::Index used = 0;                 ///< samples that the filter learns from; the rest is for comparison only
  std::optional<FreeResponseFound> free_response;
};

}  // namespace kalfem
