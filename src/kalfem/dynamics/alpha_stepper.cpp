#include <cmath>
#include <complex>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/stepper.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/linalg/sparse_operations.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;

constexpr double largest_step = 2.0;  ///< omega h; a period is two steps long at pi

/// [A, V, D] of the scheme's motion a_k = z^k.
Eigen::Vector3cd terms_of(const Complex& z, double h, const AlphaParameters& scheme) {
  const auto& [beta, gamma, alpha_m, alpha_f] = scheme;
  const Complex v = h * ((1.0 - gamma) + gamma * z) / (z - 1.0),
                d = (h * v + h * h * ((0.5 - beta) + beta * z)) / (z - 1.0);
  const Complex inertia = (1.0 - alpha_m) * z + alpha_m, rest = (1.0 - alpha_f) * z + alpha_f;
  return {inertia, rest * v, rest * d};
}

}  // namespace

void correct_periods(LocallyNonlinearSystem& system, Eigen::Index first, double step, const AlphaParameters& scheme) {
  for (Eigen::Index i = first; i < system.size(); ++i) {
    const double stiffness = system.stiffness.coeff(i, i), decay = 0.5 * system.damping.coeff(i, i);
    if (!(stiffness > 0.0) || std::sqrt(stiffness) * step > largest_step) continue;
    const Complex root = std::sqrt(Complex(decay * decay - stiffness));
    const Eigen::Vector3cd one = terms_of(std::exp(step * (-decay + root)), step, scheme),
                           other = terms_of(std::exp(step * (-decay - root)), step, scheme);
    // of a pair the second equation is the first's conjugate: their sum and difference are its two parts
    Eigen::Matrix<double, 2, 3> parts;
    if (root.imag() != 0.0)
      parts << one.real().transpose(), one.imag().transpose();
    else
      parts << one.real().transpose(), other.real().transpose();
    const Eigen::Vector2d mass_and_damping = parts.leftCols<2>().inverse() * (-stiffness * parts.col(2));
    system.mass.coeffRef(i, i) = mass_and_damping[0];
    system.damping.coeffRef(i, i) = mass_and_damping[1];
  }
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SparseFactor factor(const SparseMatrix& matrix, const LocallyNonlinearSystem& system, const std::string& what) {
  try {
    return SparseFactor(matrix);
  } catch (const NotPositiveDefinite& error) {
    throw InvalidInput(
        "the " + what + " is not positive definite at '" + system.dofs[static_cast<std::size_t>(error.column())] + "'",
        "every degree of freedom needs a mass", "give massless degrees of freedom a mass");
  }
}

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

/// Solves (S + factor U R U^T) x = b + U R w for a low-rank U by the Woodbury identity,
///     x = y + W g,  y = S^-1 b,  W = S^-1 U,  (I + factor R U^T W) g = R (w - factor U^T y).
/// Without U it is S^-1 b.
class LowRankSolver {
public:
  LowRankSolver(const SparseFactor& sparse, const ModalDamping& damping, const SparseMatrix& mass, double factor)
      : sparse_(sparse), rates_(damping.rates), factor_(factor) {
    if (empty()) return;
    mass_weighted_modes_ = mass * damping.modes.shapes;
    response_ = sparse.solve(mass_weighted_modes_);
    MatrixXd small = factor * (rates_.asDiagonal() * (mass_weighted_modes_.transpose() * response_));
    small.diagonal().array() += 1.0;
    small_.compute(small);
  }

  [[nodiscard]] bool empty() const { return rates_.size() == 0; }
  /// `rate`: the vector w stands for, w = U^T rate.
  void solve(const VectorXd& b, const VectorXd& rate, VectorXd& x) const {
    x.resize(b.size());
    sparse_.solve(b, x);
    if (empty()) return;
    const VectorXd difference = mass_weighted_modes_.transpose() * (rate - factor_ * x);
    x.noalias() += response_ * small_.solve(rates_.cwiseProduct(difference));
  }

private:
  const SparseFactor& sparse_;
  VectorXd rates_;
  double factor_;
  MatrixXd mass_weighted_modes_, response_;  ///< U = M Phi and S^-1 U, n x p
  Eigen::PartialPivLU<MatrixXd> small_;
};

/// Generalised-alpha (Newmark and HHT as special cases) in acceleration form. The effective mass
///     M* = (1-a_m) M + (1-a_f) (gamma h C + beta h^2 K)
/// is factored once and W = M*^-1 B formed once, so that
///     a1 = a_free - (1-a_f) W f1
/// leaves a solve of size m a step. K is never multiplied: with s = 1 / ((1-a_f) beta h^2) the definition of M* gives
///     K y = s (M* y - (1-a_m) M y) - gamma/(beta h) C y,
/// so that a_free = M*^-1 [ M (s (1-a_m) y - a_m a0) + C w + P u - a_f B f0 ] - s y, with the predictor y of the
/// displacement and w = gamma/(beta h) y less the predictor of the velocity: one back-solve and one sparse product.
///
/// The scheme's a belongs to a time (a_f - a_m) h earlier than d and v [EBS02]: what is given out is carried forward,
/// to second order.
class AlphaStepper final : public Stepper {
public:
  AlphaStepper(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p,
               const ForceSolveOptions& forces)
      : system_(system),
        h_(step),
        p_(p),
        forces_(system, forces),
        directions_(system.connector_directions()),
        bases_(system.connector_bases()),
        drive_(drive_of(system)),
        product_(system.mass, system.damping),
        effective_(factor(effective_mass(system, step, p), system, "effective mass matrix of the time integration")),
        solver_(effective_, system.modal_damping, system.mass, (1.0 - p.alpha_f) * p.gamma * step) {
    const VectorXd none = VectorXd::Zero(system.size());
    response_.resize(directions_.rows(), directions_.cols());
    for (Index j = 0; j < directions_.cols(); ++j) {
      solver_.solve(directions_.col(j), none, free_);
      response_.col(j) = -(1.0 - p.alpha_f) * free_;
    }
    const MatrixXd drive = directions_.transpose() * response_;
    compliance_.resize(3 * drive.rows(), drive.cols());
    compliance_ << p.beta * h_ * h_ * drive, p.gamma * h_ * drive, drive;
  }

  ForceSolveOutcome start(Motion& motion, const VectorXd& inputs) override {
    const SparseFactor mass = factor(system_.mass, system_, "mass matrix");
    VectorXd load = drive_ * inputs - system_.damping * motion.velocity - system_.stiffness * motion.displacement;
    load -= damping_force(system_.modal_damping, system_.mass, motion.velocity);
    motion.acceleration = mass.solve(load);
    const MatrixXd response = -mass.solve(directions_);
    MatrixXd compliance = MatrixXd::Zero(3 * directions_.cols(), directions_.cols());
    compliance.bottomRows(directions_.cols()) = directions_.transpose() * response;
    const auto outcome = forces_.start(connector_motion(motion, inputs), compliance, motion);
    motion.acceleration += response * motion.force;
    acceleration_ = motion.acceleration;
    return outcome;
  }

  ForceSolveOutcome advance(Motion& motion, const VectorXd& begin, const VectorXd& end) override {
    const auto& [beta, gamma, a_m, a_f] = p_;
    const double s = 1.0 / ((1.0 - a_f) * beta * h_ * h_);
    const VectorXd& a = acceleration_;
    displacement_.noalias() = motion.displacement + (1.0 - a_f) * (h_ * motion.velocity + (0.5 - beta) * h_ * h_ * a);
    inertia_.noalias() = s * (1.0 - a_m) * displacement_ - a_m * a;
    rate_.noalias() = gamma / (beta * h_) * displacement_ - motion.velocity - ((1.0 - a_f) * (1.0 - gamma) * h_) * a;
    product_.multiply(inertia_, rate_, load_);
    input_.noalias() = (1.0 - a_f) * end + a_f * begin;
    load_ += drive_ * input_;
    if (a_f != 0.0) load_.noalias() -= directions_ * (a_f * motion.force);
    solver_.solve(load_, rate_, free_);
    free_ -= s * displacement_;

    motion.displacement += h_ * motion.velocity + h_ * h_ * ((0.5 - beta) * a + beta * free_);
    motion.velocity += h_ * ((1.0 - gamma) * a + gamma * free_);
    previous_.swap(acceleration_);
    acceleration_.swap(free_);
    motion.acceleration = acceleration_;
    const auto outcome = forces_.solve(connector_motion(motion, end), compliance_, h_, motion);
    correction_.noalias() = response_ * motion.force;
    acceleration_ += correction_;
    motion.acceleration = acceleration_;
    if (a_f != a_m) motion.acceleration += (a_f - a_m) * (acceleration_ - previous_);
    motion.velocity += gamma * h_ * correction_;
    motion.displacement += beta * h_ * h_ * correction_;
    return outcome;
  }

private:
  static SparseMatrix effective_mass(const LocallyNonlinearSystem& system, double h, const AlphaParameters& p) {
    const double f = 1.0 - p.alpha_f;
    return (1.0 - p.alpha_m) * system.mass + (f * p.gamma * h) * system.damping +
           (f * p.beta * h * h) * system.stiffness;
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
  MatrixXd directions_, bases_, response_, compliance_;
  SparseMatrix drive_;
  PairedProduct product_;  ///< of M and C
  SparseFactor effective_;
  LowRankSolver solver_;
  VectorXd acceleration_, previous_;  ///< of the scheme, and a step before
  VectorXd displacement_, inertia_, rate_, load_, input_, free_, correction_;
};

}  // namespace

std::unique_ptr<Stepper> make_alpha_stepper(const LocallyNonlinearSystem& system, double step,
                                            const AlphaParameters& parameters, const ForceSolveOptions& forces) {
  return std::make_unique<AlphaStepper>(system, step, parameters, forces);
}

}  // namespace kalfem
