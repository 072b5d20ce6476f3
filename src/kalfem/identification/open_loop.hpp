// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct EstimationProblem;
struct RecordEstimate;

/// A structure that is simulated over a record without any correction by measurements.
struct OpenLoopModel {
  const LocallyNonlinearSystem& system;
  const CoupledModel& points;  ///< that the sensors observe, of the same degrees of freedom as the system
  const std::vector<Sensor>& sensors;
  const std::vector<SignalPtr>& signals;  ///< one an input
};

/// Simulates the sensors of the model at the samples of a record: `initial` is the state at its first sample.
ConvergedSolution simulate_open_loop(const OpenLoopModel& model, const InitialState& initial, const Record& record);

/// Why the simulation cannot be compared with the record, in words; empty if it can. `what` is the clause that names
/// the simulation: "the simulation with the estimates".
std::string open_loop_failure(const ConvergedSolution& simulated, const Record& measured, const std::string& what);

/// Simulates an estimation's record from its estimated parameters and initial state alone, and compares both. A
/// diverging simulation is a result: the estimates do not describe the structure. `setup`: of the estimation.
void set_open_loop(const EstimationProblem& problem, const AugmentedModelSetup& setup, RecordEstimate& estimate);

}  // namespace kalfem
