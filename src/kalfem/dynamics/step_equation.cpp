// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/step_equation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/large_pages.hpp"
#include "kalfem/linalg/single_precision_factor.hpp"
#include "kalfem/linalg/sparse_operations.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double worth_rounding = 30e6;   ///< [byte] of L; smaller ones stay in the processor's cache
constexpr double tolerable_error = 1e-3;  ///< of what a step adds; the next step's residual has it again

SparseMatrix effective_mass(const LocallyNonlinearSystem& system, double h, const AlphaParameters& p) {
  const double f = 1.0 - p.alpha_f;
  return (1.0 - p.alpha_m) * system.mass + (f * p.gamma * h) * system.damping + (f * p.beta * h * h) * system.stiffness;
}

/// Modal damping's part of M*, of low rank: from y = S^-1 b to the solution of
///     (S + factor U R U^T) x = b + U R w
/// by the Woodbury identity,
///     x = y + S^-1 U g,  (I + factor R U^T S^-1 U) g = R (w - factor U^T y),  U = M Phi.
/// `Scalar` is what U and S^-1 U are kept in: it is their memory that takes the time.
template <typename Scalar>
class LowRankPart {
public:
  LowRankPart(const SparseFactor& sparse, const ModalDamping& damping, const SparseMatrix& mass, double factor)
      : rates_(damping.rates), factor_(factor) {
    if (rates_.size() == 0) return;
    const MatrixXd mass_weighted_modes = mass * damping.modes.shapes, response = sparse.solve(mass_weighted_modes);
    MatrixXd small = factor * (rates_.asDiagonal() * (mass_weighted_modes.transpose() * response));
    small.diagonal().array() += 1.0;
    small_.compute(small);
    mass_weighted_modes_ = mass_weighted_modes.cast<Scalar>();
    response_ = response.cast<Scalar>();
    move_to_large_pages(mass_weighted_modes_);
    move_to_large_pages(response_);
  }
  /// `rate`: the vector w stands for, w = U^T rate.
  void complete(const VectorXd& rate, VectorXd& x) const {
    if (rates_.size() == 0) return;
    const Vector difference = mass_weighted_modes_.transpose() * (rate - factor_ * x).template cast<Scalar>();
    const VectorXd amplitudes = small_.solve(rates_.cwiseProduct(difference.template cast<double>()));
    const Vector added = response_ * amplitudes.template cast<Scalar>();
    x += added.template cast<double>();
  }

private:
  using Vector = Eigen::Vector<Scalar, Eigen::Dynamic>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  VectorXd rates_;
  double factor_;
  Matrix mass_weighted_modes_, response_;  ///< U and S^-1 U, n x p
  Eigen::PartialPivLU<MatrixXd> small_;
};

/// What both solutions have in common.
template <typename Scalar>
struct Parts {
  Parts(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p, const SparseFactor& effective)
      : system(system),
        h(step),
        p(p),
        directions(system.connector_directions()),
        modal_damping(effective, system.modal_damping, system.mass, (1.0 - p.alpha_f) * p.gamma * step),
        response(-(1.0 - p.alpha_f) * effective.solve(directions)) {
    const VectorXd none = VectorXd::Zero(system.size());
    for (auto column : response.colwise()) {
      VectorXd completed = column;
      modal_damping.complete(none, completed);
      column = completed;
    }
    move_to_large_pages(response);
  }

  const LocallyNonlinearSystem& system;
  double h;
  AlphaParameters p;
  MatrixXd directions;  ///< B
  LowRankPart<Scalar> modal_damping;
  MatrixXd response;  ///< W
};

/// With M* in double precision K is never multiplied: with s = 1 / ((1-a_f) beta h^2) the definition of M* gives
///     K y = s (M* y - (1-a_m) M y) - gamma/(beta h) C y,
/// so that
///     a_free = M*^-1 [ M (s (1-a_m) y - a_m a0) + C w + P u - a_f B f0 ] - s y
/// with the predictor y of the displacement and w = gamma/(beta h) y less the predictor of the velocity: one back-solve
/// and one sparse product.
class DirectEquation final : public StepEquation {
public:
  DirectEquation(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p, SparseFactor effective)
      : effective_(std::move(effective)), parts_(system, step, p, effective_), product_(system.mass, system.damping) {}

  void solve(const Motion& begin, const VectorXd& a, const VectorXd& load, VectorXd& free) override {
    const auto& [beta, gamma, a_m, a_f] = parts_.p;
    const double h = parts_.h, s = 1.0 / ((1.0 - a_f) * beta * h * h);
    displacement_.noalias() = begin.displacement + (1.0 - a_f) * (h * begin.velocity + (0.5 - beta) * h * h * a);
    inertia_.noalias() = s * (1.0 - a_m) * displacement_ - a_m * a;
    rate_.noalias() = gamma / (beta * h) * displacement_ - begin.velocity - ((1.0 - a_f) * (1.0 - gamma) * h) * a;
    product_.multiply(inertia_, rate_, load_);
    load_ += load;
    if (a_f != 0.0) load_.noalias() -= parts_.directions * (a_f * begin.force);
    free.resize(load_.size());
    effective_.solve(load_, free);
    parts_.modal_damping.complete(rate_, free);
    free -= s * displacement_;
  }

  [[nodiscard]] const MatrixXd& response() const override { return parts_.response; }

private:
  SparseFactor effective_;
  Parts<double> parts_;
  PairedProduct product_;  ///< of M and C
  VectorXd displacement_, inertia_, rate_, load_;
};

/// With M* in single precision its solution gives what a step adds to the acceleration and connector forces that it
/// begins with,
///     M* (a1 - a0) = P u - B f0 - M a0 - C v_{1-a_f} - K d_{1-a_f}   with a1 = a0 and f1 = f0 in v and d,
/// whose right side is computed in double precision: the error is a part of the change, not of the acceleration, and
/// what it leaves unbalanced is in the next step's right side. K is multiplied, which costs less than L in half its
/// size saves.
class IncrementalEquation final : public StepEquation {
public:
  IncrementalEquation(const LocallyNonlinearSystem& system, double step, const AlphaParameters& p,
                      const SparseFactor& effective, SinglePrecisionFactor rounded, double error)
      : parts_(system, step, p, effective),
        rounded_(std::move(rounded)),
        error_(error),
        product_(system.stiffness, system.mass) {}

  void solve(const Motion& begin, const VectorXd& a, const VectorXd& load, VectorXd& free) override {
    const double f = 1.0 - parts_.p.alpha_f, h = parts_.h;
    displacement_.noalias() = begin.displacement + f * h * begin.velocity + (0.5 * f * h * h) * a;
    velocity_.noalias() = begin.velocity + f * h * a;
    product_.multiply(displacement_, a, residual_);
    residual_ = load - residual_;
    residual_.noalias() -= parts_.directions * begin.force;
    if (parts_.system.damping.nonZeros() > 0) residual_.noalias() -= parts_.system.damping * velocity_;
    rounded_.solve(residual_, free);
    velocity_ = -velocity_;
    parts_.modal_damping.complete(velocity_, free);
    free += a;
    if (begin.force.size() > 0) free.noalias() -= parts_.response * begin.force;
  }

  [[nodiscard]] const MatrixXd& response() const override { return parts_.response; }
  [[nodiscard]] double error() const override { return error_; }

private:
  Parts<float> parts_;
  SinglePrecisionFactor rounded_;
  double error_;
  PairedProduct product_;  ///< of K and M
  VectorXd displacement_, velocity_, residual_;
};

/// Largest error of single-precision solutions against double-precision ones, relative, in the norm of A: for loads on
/// the connectors, and one everywhere.
double error_of(SinglePrecisionFactor& rounded, const SparseFactor& exact, const SparseMatrix& matrix,
                const MatrixXd& directions) {
  std::mt19937 random;
  const VectorXd everywhere = VectorXd::NullaryExpr(matrix.rows(), [&] { return std::ldexp(random(), -31) - 1.0; });
  MatrixXd loads(matrix.rows(), directions.cols() + 1);
  loads << directions, everywhere;
  const MatrixXd solutions = exact.solve(loads);
  double largest = 0.0;
  VectorXd error;
  for (Index j = 0; j < loads.cols(); ++j) {
    rounded.solve(loads.col(j), error);
    error -= solutions.col(j);
    const double part = std::sqrt(error.dot(matrix * error) / solutions.col(j).dot(loads.col(j)));
    largest = std::isfinite(part) ? std::max(largest, part) : std::numeric_limits<double>::infinity();
  }
  return largest;
}

}  // namespace

SparseFactor factor_of(const SparseMatrix& matrix, const LocallyNonlinearSystem& system, const std::string& what) {
  try {
    return SparseFactor(matrix);
  } catch (const NotPositiveDefinite& error) {
    throw InvalidInput(
        "the " + what + " is not positive definite at '" + system.dofs[static_cast<std::size_t>(error.column())] + "'",
        "every degree of freedom needs a mass", "give massless degrees of freedom a mass");
  }
}

std::unique_ptr<StepEquation> make_step_equation(const LocallyNonlinearSystem& system, double step,
                                                 const AlphaParameters& p, FactorPrecision precision) {
  const SparseMatrix matrix = effective_mass(system, step, p);
  SparseFactor effective = factor_of(matrix, system, "effective mass matrix of the time integration");
  const bool may_round = precision == FactorPrecision::single ||
                         (precision == FactorPrecision::automatic && effective.bytes() > worth_rounding);
  if (auto rounded = may_round ? effective.in_single_precision() : std::nullopt) {
    const double error = error_of(*rounded, effective, matrix, system.connector_directions());
    if (error < tolerable_error)
      return std::make_unique<IncrementalEquation>(system, step, p, effective, std::move(*rounded), error);
  }
  return std::make_unique<DirectEquation>(system, step, p, std::move(effective));
}

}  // namespace kalfem
