#pragma once

#include <vector>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/system/sensors/measurement_chain.hpp"

namespace kalfem {

/// When a reference solution counts as converged.
struct ConvergenceOptions {
  double sample_rate = 1000.0;      ///< of the record [Hz]
  Eigen::Index first_substeps = 4;  ///< time steps per sample of the first solution
  Eigen::Index max_substeps = 256;  ///< no finer than this
  /// Halving the step must change every sensor's record by less than this part of its rms; second-order schemes then
  /// err by a third of it. Extrapolated solutions may change by more, 5 or 21 times, so that they err by as much, once
  /// the plain ones show their order.
  double tolerance = 1e-3;
  /// Whether the step is halved at all. Without, the solution with `first_substeps` is the reference, whatever its
  /// error.
  bool refine = true;
  /// With two, the first two solutions are made side by side, or three (not where snapshots are taken). Results do not
  /// depend on it.
  int threads = 1;
};

/// A solution whose step was halved until the sensors' records stopped moving.
struct ConvergedSolution {
  SimulationResult simulation = {};  ///< sampled at the record's rate
  Eigen::MatrixXd sensors = {};  ///< behind their measurement chains, free of noise, l x samples; empty after a failure
  Eigen::Index substeps = 0;     ///< time steps per sample of the finest solution
  Eigen::Index extrapolations = 0;  ///< powers of the step that were extrapolated out of the error: h^2, h^4
  double last_change = 0.0;  ///< largest relative change of a sensor's record in the last halving, by its gain where
                             ///< extrapolated
  bool converged = false;
  /// The same of every halving since the last failure, coarsest first.
  std::vector<double> changes = {};

  /// Whether halving the step has stopped helping: of at least three halvings the last one has moved the records by
  /// more than 1e-4, and by more than 0.7 of what the last but two has, where an error of order h^p gives 4^-p. So it
  /// is where the motion is chaotic: trajectories that differ by rounding part.
  [[nodiscard]] bool stagnates() const;
};

/// Simulates with the options' integrator, duration and outputs (their step and keep_every are set here), halving the
/// step. Where the motion is smooth, the error of all integrators is a series in h^2, so that solutions S of successive
/// steps are extrapolated to h = 0 [BS66],
///     S_k,j = S_k,j-1 + (S_k,j-1 - S_k-1,j-1) / (4^j - 1),  j = 1, 2:
/// the phase of modes that ring long needs far smaller steps otherwise. Of the sequences j = 0, 1, 2 the one that moves
/// least is taken: where friction or a stop spoils the series, that is the plain one.
/// Throws InvalidInput on unsuitable options.
ConvergedSolution simulate_converged(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                                     const InitialState& initial, const OutputMap& sensors,
                                     const std::vector<MeasurementChain>& chains, SimulationOptions simulation,
                                     const ConvergenceOptions& options);

}  // namespace kalfem
