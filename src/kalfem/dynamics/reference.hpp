#pragma once

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/system/measurement_chain.hpp"

namespace kalfem {

/// When a reference solution counts as converged.
struct ReferenceOptions {
  double sample_rate = 1000.0;      ///< of the record [Hz]
  Eigen::Index first_substeps = 4;  ///< time steps per sample of the first solution
  Eigen::Index max_substeps = 256;  ///< no finer than this
  /// Halving the step must change every sensor's record by less than this part of its rms. Second-order schemes then
  /// err by a third of it.
  double tolerance = 1e-3;
};

/// A solution whose step was halved until the sensors' records stopped moving.
struct Reference {
  SimulationResult simulation;  ///< sampled at the record's rate
  Eigen::MatrixXd sensors;      ///< behind their measurement chains, free of noise, samples x l; empty after a failure
  Eigen::Index substeps = 0;    ///< time steps per sample that were used
  double last_change = 0.0;     ///< largest relative change of a sensor's record in the last halving
  bool converged = false;
};

/// Simulates with the options' integrator, duration and outputs (their step and keep_every are set here), refining the
/// step. Throws InvalidInput on unsuitable options.
Reference simulate_reference(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                             const InitialState& initial, const OutputMap& sensors,
                             const std::vector<MeasurementChain>& chains, SimulationOptions simulation,
                             const ReferenceOptions& options);

}  // namespace kalfem
