// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/dynamics/simulate.hpp"

namespace kalfem {

/// State of the motion at one time, as the steppers advance it.
struct Motion {
  Eigen::VectorXd displacement, velocity, acceleration;  ///< n
  Eigen::VectorXd force;                                 ///< connector forces, m
  Eigen::VectorXd connector_states;                      ///< internal states of all connectors
};

/// Advances a motion by one step h. Holds everything that is constant (factors, connector compliances) and the arrays
/// of one thread.
class Stepper {
public:
  virtual ~Stepper() = default;
  /// Forces and accelerations that belong to the displacements, velocities and inputs of the start.
  virtual ForceSolveOutcome start(Motion& motion, const Eigen::VectorXd& inputs) = 0;
  /// From the inputs [r; r'; r''] at the begin to those at the end of the step.
  virtual ForceSolveOutcome advance(Motion& motion, const Eigen::VectorXd& begin, const Eigen::VectorXd& end) = 0;
  /// See SimulationResult.
  [[nodiscard]] virtual double solve_error() const { return 0.0; }
};

std::unique_ptr<Stepper> make_alpha_stepper(const LocallyNonlinearSystem& system, double step,
                                            const AlphaParameters& parameters, const ForceSolveOptions& forces,
                                            FactorPrecision precision = FactorPrecision::automatic);
std::unique_ptr<Stepper> make_exact_stepper(const LocallyNonlinearSystem& system, double step,
                                            const ForceSolveOptions& forces);

/// The connectors of one system at the single point of a simulation: start and end motion as vectors.
class SinglePointForces {
public:
  SinglePointForces(const LocallyNonlinearSystem& system, const ForceSolveOptions& options);

  /// Solves at the start of a simulation: motion k_free (3m) as it is without connector forces.
  ForceSolveOutcome start(const Eigen::VectorXd& free_motion, const Eigen::MatrixXd& compliance, Motion& motion);
  /// Solves at a step's end; the begin is what the last solve left. Updates force and connector states of the motion.
  ForceSolveOutcome solve(const Eigen::VectorXd& free_motion, const Eigen::MatrixXd& compliance, double duration,
                          Motion& motion);

private:
  ConnectorForces forces_;
  Eigen::Index connectors_;
};

/// Lets a scheme of the generalised-alpha family (Newmark, HHT) with step h carry single oscillators without an error
/// in period and decay. A motion a_k = z^k of the scheme has
///     v = h ((1 - gamma) + gamma z) / (z - 1) a,      d = (h v + h^2 ((1/2 - beta) + beta z) a) / (z - 1),
/// and satisfies m A + c V + k D = 0 with A = (1 - alpha_m) z a + alpha_m a and V, D alike with alpha_f. An oscillator
/// with poles s_1, s_2 of 1, 2 zeta omega, omega^2 keeps them where that holds for z = exp(s_i h), two real equations
/// for m and c; k stays omega^2, and with it the static deflection.
/// What is left is an error of (omega h)^2 / 6 at most in the answer to a force, which does not grow with the number of
/// cycles. Changes M and C of the coordinates from `first` on, which nothing but connectors and loads may join to
/// others and whose mass is 1. Coordinates with omega h > 2, and those without stiffness, are left as they are.
void correct_periods(LocallyNonlinearSystem& system, Eigen::Index first, double step,
                     const AlphaParameters& scheme = {});

}  // namespace kalfem
