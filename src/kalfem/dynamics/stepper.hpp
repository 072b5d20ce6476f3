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
};

std::unique_ptr<Stepper> make_alpha_stepper(const LocallyNonlinearSystem& system, double step,
                                            const AlphaParameters& parameters, const ForceSolveOptions& forces);
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

}  // namespace kalfem
