// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace kalfem {

struct RecordEstimate;

/// What every sample tells of one unknown.
struct UnknownScore {
  std::string name;
  /// d ln p(y_k | y_1 .. y_k-1) / d theta at the last estimate, one a sample [1 / the unknown's unit].
  Eigen::VectorXd value;
};

/// Of the unknowns that stay constant. Empty where the filter stopped, and for a record too long to keep the course of
/// so many unknowns at every sample.
std::vector<UnknownScore> scores_of_unknowns(const RecordEstimate& estimate);

}  // namespace kalfem
