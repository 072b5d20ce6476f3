// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/resumable.hpp"

namespace kalfem {

/// Values of one channel of a stream, one after the other in time.
struct StreamBlock {
  std::string column;
  std::string unit;            ///< that stands beside the column's name; empty: none
  double time = 0.0;           ///< of the first value [s]
  double interval = 0;         ///< between two values [s]; 0: that of the sampling rate
  std::vector<double> values;  ///< not a number where missing
};

/// Reads the lines of a stream: JSON objects and lines of CSV, in any order.
///     {"t": 1.25, "a3": 0.31, "road": 0.002}                 one sample of some channels
///     {"t": 1.25, "dt": 0.002, "a3": [0.31, null, 0.28]}     some successive ones
///     {"t": 1.25, "unit": "g", "a3": 0.031}                  in a unit, that of every channel of the line
///     t,a3 [g],road                                          names of the columns, and then
///     1.25,0.031,0.002                                       samples of them; an empty place is missing
/// A line of CSV whose first place is no number gives the names of those behind it; the first column is the time.
class StreamLines final : public Resumable {
public:
  /// Throws InvalidInput for a line that is neither. A line of names holds no blocks.
  std::vector<StreamBlock> read(std::string_view line);

  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;

  static constexpr std::size_t longest_line = 1'000'000;  ///< bytes

private:
  std::vector<StreamBlock> read_row(std::string_view line);

  std::vector<std::string> columns_, units_;  ///< of CSV, the time among them
};

}  // namespace kalfem
