#include "kalfem/dynamics/stepper.hpp"

namespace kalfem {

SinglePointForces::SinglePointForces(const LocallyNonlinearSystem& system, const ForceSolveOptions& options)
    : forces_(system, options), connectors_(system.connector_count()) {}

ForceSolveOutcome SinglePointForces::start(const Eigen::VectorXd& free_motion, const Eigen::MatrixXd& compliance,
                                           Motion& motion) {
  forces_.begin_motion().row(0) = free_motion.transpose().array();
  motion.force = Eigen::VectorXd::Zero(connectors_);
  return solve(free_motion, compliance, 0.0, motion);
}

ForceSolveOutcome SinglePointForces::solve(const Eigen::VectorXd& free_motion, const Eigen::MatrixXd& compliance,
                                           double duration, Motion& motion) {
  forces_.free_motion().row(0) = free_motion.transpose().array();
  forces_.begin_states().row(0) = motion.connector_states.transpose().array();
  forces_.force().row(0) = motion.force.transpose().array();
  const auto outcome = forces_.solve(compliance, duration);
  motion.force = forces_.force().row(0).transpose().matrix();
  if (duration > 0.0) motion.connector_states = forces_.states().row(0).transpose().matrix();
  forces_.begin_motion() = forces_.motion();
  return outcome;
}

}  // namespace kalfem
