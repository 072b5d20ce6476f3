// SPDX-License-Identifier: Apache-2.0
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
  /// Halving the step would change every sensor's record by less than this part of its rms, were the solution a plain
  /// one of second order: it errs by at most a third of it. The error is estimated from the last change.
  double tolerance = 1e-3;
  /// Whether the step is refined at all. Without, the solution with `first_substeps` is the reference, whatever its
  /// error.
  bool refine = true;
  /// With two, the first two solutions are made side by side, or three (not where snapshots are taken). Results do not
  /// depend on it.
  int threads = 1;
};

/// A solution whose step was refined until the sensors' records stopped moving.
struct ConvergedSolution {
  SimulationResult simulation = {};  ///< sampled at the record's rate
  Eigen::MatrixXd sensors = {};  ///< behind their measurement chains, free of noise, l x samples; empty after a failure
  Eigen::Index substeps = 0;     ///< time steps per sample of the finest solution
  Eigen::Index extrapolations = 0;  ///< powers of the step that were extrapolated out of the error: h^2, h^4
  double last_change = 0.0;         ///< three times the largest relative error of a sensor's record, see `tolerance`
  bool converged = false;
  /// Largest relative change of a sensor's record between successive plain solutions since the last failure, coarsest
  /// first.
  std::vector<double> changes = {};

  /// Whether refining the step has stopped helping: of at least three changes the last one is more than 1e-4, and more
  /// than 0.7 of the last but two, where an error in h gives at most a half. So it is where the motion is chaotic:
  /// trajectories that differ by rounding part.
  [[nodiscard]] bool stagnates() const;
};

/// Simulates with the options' integrator, duration and outputs (their step and keep_every are set here), with n_k = 1,
/// 2, 3, 6, 12, 24 ... times `first_substeps` time steps a sample. Where the motion is smooth, the error of all
/// integrators is a series in h^2, so that the solutions are extrapolated to h = 0 [BS66],
///     S_k,j = S_k,j-1 + (S_k,j-1 - S_k-1,j-1) / ((n_k / n_k-j)^2 - 1),  j = 1, 2:
/// the phase of modes that ring long needs far smaller steps otherwise. The added term is the error of S_k,j-1 as its
/// change tells it, and the S_k,j of the least such error is taken. But as long as the last two changes of S_.,j-1 do
/// not show its order, being nearer to those of an error in h^(2j) than to those of one in h^j, the error of S_k,j is
/// taken from its change as if it had not been extrapolated that often: where friction or a stop spoils the series, the
/// plain one prevails. Throws InvalidInput on unsuitable options.
ConvergedSolution simulate_converged(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                                     const InitialState& initial, const OutputMap& sensors,
                                     const std::vector<MeasurementChain>& chains, SimulationOptions simulation,
                                     const ConvergenceOptions& options);

}  // namespace kalfem
