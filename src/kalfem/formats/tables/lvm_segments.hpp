// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of LabVIEW measurement files only.

#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// A channel of a segment with the lines of its samples.
struct LvmChannel {
  MeasuredChannel channel;
  Eigen::VectorXd stamps;  ///< X_Value, with X0; empty: there is no such column
  std::vector<int> lines;  ///< of the samples
  bool of_frequency = false;
};

struct LvmContents {
  std::vector<std::vector<LvmChannel>> segments;
  std::vector<std::string> notes;
};

/// Adds the channels of all segments, and the functions of frequency. Segments of the same channels that go on in time
/// are joined; the channels of others are "a (segment 2)".
void add_segments(std::vector<std::vector<LvmChannel>> segments, MeasuredFile& file);

}  // namespace kalfem
