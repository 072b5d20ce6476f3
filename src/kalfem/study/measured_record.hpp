#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

struct FullRecord;
struct Study;

/// Release and rest of a free response, as found in its record.
struct FreeResponseFound {
  double release = 0.0;        ///< time in the file [s]
  std::optional<double> rest;  ///< time in the file from which the structure is at rest [s]; nothing if it never is
  Eigen::VectorXd position;    ///< subtracted from each channel: its rest position, or the middle of its last swing
  Eigen::VectorXd
      deviation;  ///< prior standard deviation of the rest position about it; empty if the position is known

  [[nodiscard]] bool rest_is_unknown() const { return deviation.size() > 0; }
};

/// The measured record of a case, cut and prepared as it asks.
struct MeasuredRecord {
  TimeSeries series;                     ///< one channel per sensor, SI; start is the time in the file
  std::vector<std::string> preparation;  ///< the steps of its preparation, one sentence each
  Eigen::Index used = 0;                 ///< samples that the filter uses; the rest serves comparison only
  std::optional<FreeResponseFound> free_response;
};

/// The measured record of the study with the noise of each channel [SI]. Throws InvalidInput if the noise of a sensor
/// is a percentage of a channel that is 0 throughout: that is no noise.
FullRecord measured_record(const Study& study);

/// Throws the same for a simulated record. `noise`: one a sensor; `channel` names the channel in the message.
void check_noise(const Study& study, const std::vector<double>& noise, const std::string& channel);

}  // namespace kalfem
