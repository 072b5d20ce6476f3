#pragma once

#include "kalfem/base/time_series.hpp"
#include "kalfem/casefile/description.hpp"

namespace kalfem {

/// The measured record of a case, cut and prepared as it asks.
struct MeasuredRecord {
  TimeSeries series;                     ///< one channel a sensor, SI; start is the time in the file
  std::vector<std::string> preparation;  ///< what was done to it, in words
  Eigen::Index used = 0;                 ///< samples that the filter learns from; the rest is for comparison only
};

/// Reads the channels of the case's sensors. Throws InvalidInput (missing file or channel, samples that are not finite
/// unless the case skips them, an empty part).
MeasuredRecord read_measured_record(const description::Case& given);

}  // namespace kalfem
