// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// Where a motion starts.
struct InitialState {
  Eigen::VectorXd displacement;      ///< [m], n
  Eigen::VectorXd velocity;          ///< [m/s], n
  Eigen::VectorXd connector_states;  ///< internal states of all connectors, in order
};

/// Rest at zero.
InitialState at_rest(Eigen::Index dofs, Eigen::Index connector_states);

/// Motion at equally spaced times; column k is the time k * step. The motions are empty where they were not to be kept.
struct Trajectory {
  double step = 0.0;                 ///< [s]
  Eigen::MatrixXd displacement;      ///< n x samples
  Eigen::MatrixXd velocity;          ///< n x samples
  Eigen::MatrixXd acceleration;      ///< n x samples
  Eigen::MatrixXd force;             ///< connector forces, m x samples
  Eigen::MatrixXd inputs;            ///< [r; r'; r''], 3 n_u x samples
  Eigen::MatrixXd connector_states;  ///< states x samples

  [[nodiscard]] Eigen::Index samples() const { return inputs.cols(); }
};

/// Why a simulation ended before its last sample.
struct SimulationFailure {
  double time = 0.0;   ///< [s]
  std::string reason;  ///< in words
};

struct SimulationResult {
  Trajectory trajectory;         ///< samples before the failure, where there was one
  Eigen::MatrixXd every_step;    ///< the outputs asked for at every step before a failure, outputs x (steps + 1)
  Eigen::MatrixXd every_sample;  ///< the outputs asked for at every stored sample, outputs x samples
  std::optional<SimulationFailure> failure;  ///< empty: it ran to the end
  double solve_error = 0.0;  ///< of a factor in single precision: the part of what a step adds to the acceleration that
                             ///< its solution errs by, in the norm of the effective mass; 0: double precision
};

}  // namespace kalfem
