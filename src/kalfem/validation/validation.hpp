// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/step_budget.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/system/signal.hpp"
#include "kalfem/validation/estimated_structure.hpp"

namespace kalfem {

/// A part of a record that is simulated in open loop.
struct ValidationPart {
  PreparedRecord record;
  std::vector<SignalPtr> signals;  ///< one an input, over the time of that record
  double lead_in = 0.0;            ///< first part of it, from which the initial state is estimated [s]
  bool from_rest = false;          ///< instead, the structure is at rest at its first sample
};

/// A structure with the parameters that were found, and the data to try them on.
struct ValidationProblem {
  EstimatedStructure structure;
  ValidationPart held_back;           ///< that the parameters were not found from
  std::optional<ValidationPart> own;  ///< that they were found from, for comparison
  /// How the structure usually moves: the prior of the initial state. Empty: as in a simulation of the held-back part
  /// from rest.
  std::optional<MotionRange> motion = {};
  double steps = StepBudget::unlimited;  ///< of the filter, for predictions one sample ahead
};

/// A part of a record beside its open-loop simulation.
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

/// Parameters on data that they were not found from, and beside it the same on those that they were.
struct Validation {
  OpenLoopComparison held_back, own;
  bool one_step_left_out = false;  ///< in one of them, as the problem's steps allow no further run
};

/// Simulates both parts in open loop, each in the same way: a fixed-point smoother finds the state at the first sample
/// from a short lead-in with the parameters held, then the whole part is simulated, and the samples behind the lead-in
/// count. Parameters that make no structure are a failure in the result.
Validation validate(const ValidationProblem& problem);

}  // namespace kalfem
