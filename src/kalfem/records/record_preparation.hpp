// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// What was found of a free response and taken off its record.
struct FreeResponseFound {
  double release = 0.0;        ///< time in the file [s]
  std::optional<double> rest;  ///< time in the file from which the structure is at rest [s]; nothing: it never is
  Eigen::VectorXd position;   ///< that was taken off each channel: where it rests, or else the middle of its last swing
  Eigen::VectorXd deviation;  ///< prior standard deviation of the rest position about it; empty: it is known

  [[nodiscard]] bool rest_is_unknown() const { return deviation.size() > 0; }
};

/// A record as the filter is handed it, and what was done to it.
struct PreparedRecord {
  Record record;                              ///< SI; start is the time in the file
  std::vector<std::string> preparation = {};  ///< in words
  std::optional<FreeResponseFound> free_response = {};
  std::optional<double> began = {};  ///< time in the file of its first sample, where the record is a part of it [s]
};

/// Puts back the samples that are missing at a splice, as missing. Nothing changes where there is no splice.
void repair_splice(PreparedRecord& prepared);

/// Which part of a free response is taken.
struct FreeResponsePart {
  double delay = 0.0;      ///< it begins so long after the release [s]
  double threshold = 0.0;  ///< motion counts up to the last sample that is further from rest than this [channels' unit]
  double margin = 0.0;     ///< the filter learns from so much more after that sample [s]
  /// Prior standard deviation of a channel's rest position where the record ends before the rest; nothing, or no entry:
  /// half of the last swing.
  std::vector<std::optional<double>> rest_deviation = {};
};

/// Takes the record from its release on, relative to the rest position that follows; what disturbs the end of the rest
/// is kept for comparison, the filter does not learn from it. Where the record ends before the rest, it is relative to
/// the middle of the last swing, about which the rest position is unknown. Throws InvalidInput where there is no
/// release.
void take_free_response(PreparedRecord& prepared, const FreeResponsePart& part);

}  // namespace kalfem
