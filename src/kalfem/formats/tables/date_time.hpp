// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kalfem {

/// Which of day and month comes first in 03/05/2024.
enum class DateOrder { month_first, day_first };

/// A date with or without a time of day, or a time of day alone.
struct DateTime {
  std::int64_t days = 0;  ///< since 1970-01-01; 0 without a date
  double seconds = 0.0;   ///< of the day, less the zone's offset
  bool has_date = false, has_time = false;
};

/// The date and time that fill the whole text, as programs write them: 2024-03-05T14:02:03.25Z, 2024/03/05 14:02:03,
/// 05.03.2024 14:02:03,25, 3/5/2024 2:02:03.25 PM, 14:02:03.25, 2024-03-05. The year has four digits. Nothing where it
/// is none.
std::optional<DateTime> parse_date_time(std::string_view text, DateOrder order = DateOrder::month_first);

/// A column of dates and times of day.
struct StampColumn {
  Eigen::VectorXd seconds;              ///< since the first one; NaN where the cell is empty
  bool dates_only = false;              ///< none has a time of day
  std::optional<std::size_t> odd = {};  ///< the first cell that holds something else
};

/// Times without a date that run back by more than half a day are of the next day. Whether day or month comes first is
/// what makes the column shorter.
StampColumn read_stamp_column(const std::vector<std::string_view>& cells);

}  // namespace kalfem
