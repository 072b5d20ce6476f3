// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/stepper.hpp"

#include "kalfem/dynamics/first_order_form.hpp"

namespace kalfem {

SinglePointForces::SinglePointForces(const LocallyNonlinearSystem& system, const ForceSolveOptions& options)
    : forces_(system, options), connectors_(system.connector_count()) {}

ForceSolveOutcome SinglePointForces::start(const Eigen::VectorXd& free_motion, const Eigen::MatrixXd& compliance,
                                           Motion& motion) {
  forces_.begin_motion().row(0) = free_motion.transpose().array();
  motion.force = Eigen::VectorXd::Zero(connectors_);
  return solve(free_motion, compliance, 0.0, motion);
}

// The last forces and states are the guess and the start of the interval; they advance only where time does.
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

namespace {

using Eigen::VectorXd;

// The form gives outputs of its state; z'' is asked for as one output for each degree of freedom.
OutputMap accelerations_of(const LocallyNonlinearSystem& system) {
  const auto n = system.size();
  const auto inputs = Eigen::MatrixXd::Zero(n, system.input_count());
  OutputMap map{system.dofs,
                std::vector<std::string>(system.dofs.size(), "m/s^2"),
                SparseRows(n, n),
                SparseRows(n, n),
                SparseRows(n, n),
                inputs,
                inputs,
                inputs,
                Eigen::MatrixXd::Zero(n, system.connector_count())};
  map.acceleration.setIdentity();
  return map;
}

// A step, with connector forces and inputs linear in time over it (first-order hold, [VL78]):
//   1. x- = A_h x + G_0 f + P_0 u + P_1 u+: the motion without the forces at the end;
//   2. the connectors' motion follows, k = k_free + H f+ with the compliance H of their ends; solve for f+;
//   3. x+ = x- + G_1 f+, and z'' from the equation of motion.
/// The exact step of the linear part, connector forces linear over the step.
class ExactStepper final : public Stepper {
public:
  ExactStepper(const LocallyNonlinearSystem& system, double step, const ForceSolveOptions& forces)
      : form_(system, accelerations_of(system)), step_(form_, step), forces_(system, forces), state_(form_.size()) {}

  ForceSolveOutcome start(Motion& motion, const VectorXd& inputs) override {
    state_ << motion.displacement, motion.velocity;
    const VectorXd free = form_.motion().state * state_ + form_.motion().input * inputs;
    const auto outcome = forces_.start(free, step_.instant_compliance, motion);
    set_acceleration(motion, inputs);
    return outcome;
  }

  ForceSolveOutcome advance(Motion& motion, const VectorXd& begin, const VectorXd& end) override {
    next_.noalias() = step_.transition * state_;
    next_.noalias() += step_.begin_force * motion.force;
    next_.noalias() += step_.begin_input * begin;
    next_.noalias() += step_.end_input * end;
    free_.noalias() = form_.motion().state * next_;
    free_.noalias() += form_.motion().input * end;
    const auto outcome = forces_.solve(free_, step_.compliance, step_.step, motion);
    next_.noalias() += step_.end_force * motion.force;
    state_.swap(next_);
    motion.displacement = state_.head(form_.dof_count());
    motion.velocity = state_.segment(form_.dof_count(), form_.dof_count());
    set_acceleration(motion, end);
    return outcome;
  }

private:
  void set_acceleration(Motion& motion, const VectorXd& inputs) {
    motion.acceleration = form_.outputs().state * state_;
    motion.acceleration.noalias() += form_.outputs().input * inputs;
    motion.acceleration.noalias() += form_.outputs().force * motion.force;
  }

  FirstOrderForm form_;
  ExactStep step_;
  SinglePointForces forces_;
  VectorXd state_, next_, free_;
};

}  // namespace

std::unique_ptr<Stepper> make_exact_stepper(const LocallyNonlinearSystem& system, double step,
                                            const ForceSolveOptions& forces) {
  return std::make_unique<ExactStepper>(system, step, forces);
}

}  // namespace kalfem
