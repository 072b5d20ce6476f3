// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// Free response after a hold: when it starts, when it has died out, and where the structure stays.
struct FreeResponseOptions {
  double hold = 0.1;          ///< the record begins with a hold of at least this length [s]
  double departure = 0.01;    ///< a channel has left a position when it is off by this part of its largest excursion
  double noise_factor = 5.0;  ///< or by this many standard deviations of its noise, whichever is more
  Eigen::Index samples = 5;   ///< for so many samples in a row
  double still = 0.2;         ///< at rest, all channels stay where they are for at least this length [s]
};

/// The end of a hold.
struct Release {
  Eigen::Index sample = 0;   ///< the first one at which a channel has left the hold
  double time = 0.0;         ///< [s]
  Eigen::VectorXd position;  ///< mean of each channel over the hold
};

/// The first sample at which any channel has departed from where it was held. Nothing where the record does not begin
/// with a hold or never leaves it. Samples that are not finite are left out. Throws InvalidInput on options out of
/// range.
std::optional<Release> find_release(const Record& record, const FreeResponseOptions& options = {});

/// The first time after the release for which a structure stands still for good: until something else moves it.
struct Rest {
  Eigen::Index motion_end = 0;   ///< last sample at which a channel is away from its rest position
  Eigen::Index last = 0;         ///< last sample of the rest: the record's last one unless something disturbs it
  double motion_end_time = 0.0;  ///< [s]
  Eigen::VectorXd position;      ///< mean of each channel over the second half of the rest
  Eigen::VectorXd deviation;     ///< standard deviation about it
};

/// Rest after the sample `from` (a release): the first run of windows of length `still` in which every channel stays
/// within +-departure of its largest excursion so far, and their means do over as long a time as the motion has taken
/// from one turning point to the next: the pause at such a point is shorter. About a quiet window, channels may tremble
/// by twice as much. Before the first turn the run must be half
/// as long as the motion, or last to the record's end. What happens after the rest does not count. Nothing where the
/// structure never comes to rest. Samples that are not finite are left out. Throws InvalidInput as above.
std::optional<Rest> find_rest(const Record& record, Eigen::Index from, const FreeResponseOptions& options = {});

/// Release and rest of one free response. Excursions are those up to the rest, so that a disturbance after it moves
/// neither.
struct FreeResponseTimes {
  Release release;
  std::optional<Rest> rest;  ///< nothing where the record ends before it
};
std::optional<FreeResponseTimes> find_free_response(const Record& record, const FreeResponseOptions& options = {});

/// Where a structure that still moves at the record's end will rest.
struct RestGuess {
  Eigen::VectorXd position;   ///< middle of each channel's last swing
  Eigen::VectorXd deviation;  ///< half of its width
};

/// The last swing is the record from its third last passage of its later mean on, in the channel that moves most: at
/// least a whole period. Where there are fewer passages it is the last quarter of the time since `from`. Throws
/// InvalidInput as above.
RestGuess guess_rest(const Record& record, Eigen::Index from, const FreeResponseOptions& options = {});

}  // namespace kalfem
