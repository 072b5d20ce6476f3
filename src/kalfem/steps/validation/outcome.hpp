// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// A part of a record beside its open-loop simulation with the estimates.
struct OpenLoopComparison {
  Record measured;            ///< one channel a sensor of the model
  Eigen::MatrixXd simulated;  ///< sensors x samples; empty after a failure
  Eigen::Index first = 0;     ///< first sample that counts: the initial state is estimated from those before
  std::vector<double> nrmse;  ///< one a sensor: rms(simulated - measured) / rms(measured about its mean)
  std::vector<double> noise;  ///< one a sensor: stated noise / rms(measured about its mean), the least error possible
  /// One a sensor: the same of what the filter predicts one sample ahead, with the parameters held; empty where it
  /// stops, and where there is no state to predict.
  std::vector<double> one_step;
  std::string failure;  ///< in words, where there is nothing to compare
};

/// The estimates on data that they were not estimated from, and beside it the same on those that they were.
struct ValidationOutcome {
  OpenLoopComparison held_back, own;
  bool one_step_left_out = false;  ///< in one of them, as second_thoughts allow no further run
};

}  // namespace kalfem
