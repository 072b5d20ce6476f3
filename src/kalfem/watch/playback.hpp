// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

struct Study;

/// Something that a sensor does wrong.
enum class FaultKind {
  dead,    ///< it gives `value` throughout
  spike,   ///< `value` is added to one sample, and to one each second until the end
  offset,  ///< `value` is added
  gap      ///< it gives nothing
};

/// When and on which channel. Times count from the first sample.
struct ScheduledFault {
  FaultKind kind = FaultKind::dead;
  std::string channel;
  double from = 0.0, to = 0.0;  ///< [s]
  double value = 0.0;           ///< [unit of the stream]
};

/// "dead:body:10:50", "spike:wheel:3", "offset:body:10:50:0.5", "gap:body:10:12": KIND:CHANNEL:FROM[:TO[:VALUE]].
/// Without TO a fault lasts to the end, a spike one sample. Throws InvalidInput.
ScheduledFault scheduled_fault(const std::string& text);

/// A channel as it is published: in the unit that the case states for it, with its gain, offset and delay.
struct PlayedChannel {
  std::string column;
  Eigen::VectorXd values;  ///< not a number where missing
  double delay = 0.0;      ///< [s]
};

/// What `kalfem play` publishes.
struct Playback {
  double sample_rate = 1.0, start = 0.0;  ///< [Hz], [s]
  std::vector<PlayedChannel> channels;    ///< sensors, then inputs

  [[nodiscard]] Eigen::Index samples() const;
  /// Samples from `first` on, as a JSON line for each delay that channels have, without line breaks at the end.
  [[nodiscard]] std::vector<std::string> lines(Eigen::Index first, Eigen::Index count) const;
};

/// The record of a study, measured or simulated, with the inputs that drive it.
Playback playback_of(const Study& study, const Record& record);

/// Throws InvalidInput for a channel that is not published.
void apply_faults(const std::vector<ScheduledFault>& faults, Playback& playback);

}  // namespace kalfem
