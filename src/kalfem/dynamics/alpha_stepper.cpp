#include <Eigen/SparseCholesky>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/stepper.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Generalised-alpha (Newmark and HHT as special cases) in acceleration form. The effective mass
///     M* = (1-a_m) M + (1-a_f) (gamma h C + beta h^2 K)
/// is factored once and W = M*^-1 B formed once, so that
///     a1 = a_free - (1-a_f) W f1
/// leaves a solve of size m a step.
class AlphaStepper final : public Stepper {
public:
  AlphaStepper(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p,
               const ForceSolveOptions& forces)
      : system_(system),
        h_(step),
        p_(p),
        forces_(system, forces),
        directions_(system.connector_directions()),
        bases_(system.connector_bases()) {
    const double f = 1.0 - p.alpha_f;
    const SparseMatrix effective = (1.0 - p.alpha_m) * system.mass + (f * p.gamma * h_) * system.damping +
                                   (f * p.beta * h_ * h_) * system.stiffness;
    effective_.compute(effective);
    mass_.compute(system.mass);
    if (effective_.info() != Eigen::Success || mass_.info() != Eigen::Success)
      throw InvalidInput("the effective mass matrix of the time integration is not positive definite",
                         "every degree of freedom needs mass", "give massless degrees of freedom a mass");
    response_ = -f * effective_.solve(directions_);
    const MatrixXd drive = directions_.transpose() * response_;
    compliance_.resize(3 * drive.rows(), drive.cols());
    compliance_ << p.beta * h_ * h_ * drive, p.gamma * h_ * drive, drive;
    start_response_ = -mass_.solve(directions_);
    start_compliance_ = MatrixXd::Zero(3 * drive.rows(), drive.cols());
    start_compliance_.bottomRows(drive.rows()) = directions_.transpose() * start_response_;
  }

  ForceSolveOutcome start(Motion& motion, const VectorXd& inputs) override {
    motion.acceleration =
        mass_.solve(applied(inputs) - system_.damping * motion.velocity - system_.stiffness * motion.displacement);
    const auto outcome = forces_.start(connector_motion(motion, inputs), start_compliance_, motion);
    motion.acceleration += start_response_ * motion.force;
    return outcome;
  }

  ForceSolveOutcome advance(Motion& motion, const VectorXd& begin, const VectorXd& end) override {
    const auto& [beta, gamma, a_m, a_f] = p_;
    const VectorXd drift = h_ * motion.velocity + (0.5 - beta) * h_ * h_ * motion.acceleration;
    const VectorXd kick = (1.0 - gamma) * h_ * motion.acceleration;
    right_side_ = applied((1.0 - a_f) * end + a_f * begin) - a_m * (system_.mass * motion.acceleration) -
                  system_.damping * (motion.velocity + (1.0 - a_f) * kick) -
                  system_.stiffness * (motion.displacement + (1.0 - a_f) * drift) - a_f * (directions_ * motion.force);
    motion.acceleration = effective_.solve(right_side_);
    motion.displacement += drift + beta * h_ * h_ * motion.acceleration;
    motion.velocity += kick + gamma * h_ * motion.acceleration;
    const auto outcome = forces_.solve(connector_motion(motion, end), compliance_, h_, motion);
    const VectorXd correction = response_ * motion.force;
    motion.acceleration += correction;
    motion.velocity += gamma * h_ * correction;
    motion.displacement += beta * h_ * h_ * correction;
    return outcome;
  }

private:
  VectorXd applied(const VectorXd& inputs) const {
    VectorXd force = VectorXd::Zero(system_.size());
    const Index count = system_.input_count();
    for (Index i = 0; i < count; ++i) {
      const auto& input = system_.inputs[static_cast<std::size_t>(i)];
      force += inputs[i] * input.value + inputs[count + i] * input.rate + inputs[2 * count + i] * input.acceleration;
    }
    return force;
  }

  VectorXd connector_motion(const Motion& motion, const VectorXd& inputs) const {
    const Index count = system_.input_count();
    VectorXd k(3 * directions_.cols());
    k << directions_.transpose() * motion.displacement - bases_ * inputs.head(count),
        directions_.transpose() * motion.velocity - bases_ * inputs.segment(count, count),
        directions_.transpose() * motion.acceleration - bases_ * inputs.tail(count);
    return k;
  }

  const LocallyNonlinearSystem& system_;
  double h_;
  AlphaParameters p_;
  SinglePointForces forces_;
  MatrixXd directions_, bases_, response_, start_response_, compliance_, start_compliance_;
  Eigen::SimplicialLDLT<SparseMatrix> effective_, mass_;
  VectorXd right_side_;
};

}  // namespace

std::unique_ptr<Stepper> make_alpha_stepper(const LocallyNonlinearSystem& system, double step,
                                            const AlphaParameters& parameters, const ForceSolveOptions& forces) {
  return std::make_unique<AlphaStepper>(system, step, parameters, forces);
}

}  // namespace kalfem
