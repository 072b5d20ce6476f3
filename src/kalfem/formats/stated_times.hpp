// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/common_grid.hpp"

namespace kalfem {

/// The times of a channel's samples as its file states them.
struct StatedTimes {
  SampleTimes times;
  std::vector<Eigen::Index> order;  ///< of the samples in time; empty: as they stand in the file

  /// The values in the order of their times.
  [[nodiscard]] Eigen::VectorXd in_order(const Eigen::Ref<const Eigen::VectorXd>& values) const {
    if (order.empty()) return values;
    return values(order);
  }
};

/// Times from stamps [s], which may jitter and stand in any order:
///   1. Stamps that are not ascending are sorted, which `notes` says. A time that occurs twice is a problem, and so is
///      one that starts again: two measurements in one file are no record.
///   2. Stamps that time_axis() accepts are even.
///   3. Otherwise each sample has the time of its stamp. Intervals of more than 1.5 times the usual one are gaps: these
///      are problems, as in time_axis(), unless samples may be `missing`.
/// Problems have the line of the stamp. What is returned then is not usable.
StatedTimes stated_times(const Eigen::VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                         bool missing, FileProblems& problems, std::vector<std::string>* notes);

}  // namespace kalfem
