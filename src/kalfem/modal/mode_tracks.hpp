// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/modal/modal_result.hpp"
#include "kalfem/statistics/population.hpp"

namespace kalfem {

struct TrackOptions {
  double frequency = 0.1;  ///< largest relative change of a frequency from one record to the next that has the mode
  double mac = 0.8;        ///< least MAC of the shapes of the two
};

/// What a track says of a number: how it follows the covariates, and how far it scatters beside.
using TrackTrend = std::optional<PopulationTrend>;  ///< nothing where too few records have the mode

/// One mode through several records of a structure.
struct ModeTrack {
  std::vector<std::optional<std::size_t>> modes;  ///< one a record: which of its modes; nothing where it was not found
  TrackTrend frequency, damping;                  ///< with 95 % intervals; frequency in Hz
};

/// Follows modes from record to record: two are the same where their shapes agree at the channels that all records have
/// and their frequencies lie near; of several candidates the nearest shape and frequency counts. A mode that no track
/// has begins one. Ordered by frequency.
///
/// `covariates`: records x numbers, such as temperatures, which frequency and damping follow linearly; 0 columns: none.
/// Throws InvalidInput for fewer than two records, no common channel, and covariates that are not one row a record or
/// not finite.
std::vector<ModeTrack> track_modes(const std::vector<ModalResult>& records, const Eigen::MatrixXd& covariates = {},
                                   const TrackOptions& options = {});

}  // namespace kalfem
