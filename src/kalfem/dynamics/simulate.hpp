// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/dynamics/trajectory.hpp"
#include "kalfem/system/connector_forces.hpp"
#include "kalfem/system/sensors/output_map.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

enum class Integrator { newmark, hht_alpha, generalized_alpha, exact };

/// Parameters of M a_{1-alpha_m} + C v_{1-alpha_f} + K d_{1-alpha_f} + B f_{1-alpha_f} = P u_{1-alpha_f}, Chung and
/// Hulbert, J. Appl. Mech. 60 (1993) 371-375, where x_{1-alpha} = (1 - alpha) x_1 + alpha x_0.
struct AlphaParameters {
  double beta = 0.25;
  double gamma = 0.5;
  double alpha_m = 0.0;
  double alpha_f = 0.0;
};

/// Average acceleration: second order, no numerical damping. Newmark, J. Eng. Mech. Div. 85 (1959) 67-94.
AlphaParameters newmark_parameters();
/// HHT-alpha with alpha in [-1/3, 0]; Hilber, Hughes and Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283-292.
AlphaParameters hht_parameters(double alpha);
/// Generalised-alpha with the spectral radius at infinity in [0, 1].
AlphaParameters generalized_alpha_parameters(double spectral_radius);

/// Precision of the factor of the effective mass matrix in the schemes of the generalised-alpha family. Single
/// precision halves the memory that a step reads; residuals stay in double precision.
enum class FactorPrecision {
  automatic,  ///< single where the factor is large and the error of its solutions, which is measured, is below 1e-3
  single,     ///< whatever the size of the factor
  twofold     ///< double
};

struct SimulationOptions {
  Integrator integrator = Integrator::exact;
  double step = 1e-3;            ///< [s]
  double duration = 1.0;         ///< [s]
  Eigen::Index keep_every = 1;   ///< steps between stored samples
  double hht_alpha = -0.05;      ///< of hht_alpha
  double spectral_radius = 0.8;  ///< of generalized_alpha
  bool keep_motion = true;       ///< store the motion of every degree of freedom at every sample
  OutputMap every_step = {};     ///< outputs kept at every step, for measurement chains that act at the fine step
  OutputMap every_sample = {};   ///< outputs kept at every sample
  ForceSolveOptions forces = {};
  FactorPrecision precision = FactorPrecision::automatic;
  Progress progress = {};
  /// Called with the time and the displacement of every degree of freedom at every `snapshot_every`th sample.
  std::function<void(double time, const Eigen::VectorXd& displacement)> snapshot = {};
  Eigen::Index snapshot_every = 1;
};

/// Transient of the system under its inputs (one signal an input). The state at time 0 is stored first.
/// Modal damping is stepped in the coordinates of DampedModeSplit where that can be, with the damped modes' own periods
/// and decay (correct_periods()).
/// Throws InvalidInput on unsuitable options; a diverging or non-converging solve is a failure in the result.
SimulationResult simulate(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                          const InitialState& initial, const SimulationOptions& options);

}  // namespace kalfem
