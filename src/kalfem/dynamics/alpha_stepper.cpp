// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/step_equation.hpp"
#include "kalfem/dynamics/stepper.hpp"
#include "kalfem/linalg/large_pages.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// [P Q T]: force per input value, rate and acceleration, n x 3 n_u.
SparseMatrix drive_of(const LocallyNonlinearSystem& system) {
  MatrixXd drive(system.size(), 3 * system.input_count());
  for (Index i = 0; i < system.input_count(); ++i) {
    const auto& input = system.inputs[static_cast<std::size_t>(i)];
    drive.col(i) = input.value;
    drive.col(system.input_count() + i) = input.rate;
    drive.col(2 * system.input_count() + i) = input.acceleration;
  }
  return drive.sparseView();
}

/// Generalised-alpha (Newmark and HHT as special cases) in acceleration form. The equation of a step is linear in the
/// connector forces at its end, which leaves a solve of size m for them.
///
/// The scheme's a belongs to a time (a_f - a_m) h earlier than d and v [EBS02]: what is given out is carried forward,
/// to second order.
class AlphaStepper final : public Stepper {
public:
  AlphaStepper(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p,
               const ForceSolveOptions& forces, FactorPrecision precision)
      : system_(system),
        h_(step),
        p_(p),
        forces_(system, forces),
        directions_(system.connector_directions()),
        bases_(system.connector_bases()),
        drive_(drive_of(system)),
        equation_(make_step_equation(system, step, p, precision)) {
    const MatrixXd drive = directions_.transpose() * equation_->response();
    compliance_.resize(3 * drive.rows(), drive.cols());
    compliance_ << p.beta * h_ * h_ * drive, p.gamma * h_ * drive, drive;
    move_to_large_pages(drive_);
  }

  ForceSolveOutcome start(Motion& motion, const VectorXd& inputs) override {
    const SparseFactor mass = factor_of(system_.mass, system_, "mass matrix");
    VectorXd load = drive_ * inputs - system_.damping * motion.velocity - system_.stiffness * motion.displacement;
    load -= damping_force(system_.modal_damping, system_.mass, motion.velocity);
    motion.acceleration = mass.solve(load);
    const MatrixXd response = -mass.solve(directions_);
    MatrixXd compliance = MatrixXd::Zero(3 * directions_.cols(), directions_.cols());
    compliance.bottomRows(directions_.cols()) = directions_.transpose() * response;
    const auto outcome = forces_.start(connector_motion(motion, motion.acceleration, inputs), compliance, motion);
    motion.acceleration += response * motion.force;
    acceleration_ = motion.acceleration;
    return outcome;
  }

  ForceSolveOutcome advance(Motion& motion, const VectorXd& begin, const VectorXd& end) override {
    const auto& [beta, gamma, a_m, a_f] = p_;
    input_.noalias() = (1.0 - a_f) * end + a_f * begin;
    load_.noalias() = drive_ * input_;
    equation_->solve(motion, acceleration_, load_, free_);

    motion.displacement += h_ * motion.velocity + h_ * h_ * ((0.5 - beta) * acceleration_ + beta * free_);
    motion.velocity += h_ * ((1.0 - gamma) * acceleration_ + gamma * free_);
    previous_.swap(acceleration_);
    acceleration_.swap(free_);
    const auto outcome = forces_.solve(connector_motion(motion, acceleration_, end), compliance_, h_, motion);
    if (motion.force.size() > 0) {
      correction_.noalias() = equation_->response() * motion.force;
      acceleration_ += correction_;
      motion.velocity += gamma * h_ * correction_;
      motion.displacement += beta * h_ * h_ * correction_;
    }
    motion.acceleration = acceleration_;
    if (a_f != a_m) motion.acceleration += (a_f - a_m) * (acceleration_ - previous_);
    return outcome;
  }

  [[nodiscard]] double solve_error() const override { return equation_->error(); }

private:
  VectorXd connector_motion(const Motion& motion, const VectorXd& acceleration, const VectorXd& inputs) const {
    const Index count = system_.input_count();
    VectorXd k(3 * directions_.cols());
    k << directions_.transpose() * motion.displacement - bases_ * inputs.head(count),
        directions_.transpose() * motion.velocity - bases_ * inputs.segment(count, count),
        directions_.transpose() * acceleration - bases_ * inputs.tail(count);
    return k;
  }

  const LocallyNonlinearSystem& system_;
  double h_;
  AlphaParameters p_;
  SinglePointForces forces_;
  MatrixXd directions_, bases_, compliance_;
  SparseMatrix drive_;
  std::unique_ptr<StepEquation> equation_;
  VectorXd acceleration_, previous_;  ///< of the scheme, and a step before
  VectorXd input_, load_, free_, correction_;
};

}  // namespace

std::unique_ptr<Stepper> make_alpha_stepper(const LocallyNonlinearSystem& system, double step,
                                            const AlphaParameters& parameters, const ForceSolveOptions& forces,
                                            FactorPrecision precision) {
  return std::make_unique<AlphaStepper>(system, step, parameters, forces, precision);
}

}  // namespace kalfem
