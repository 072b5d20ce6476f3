// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/dynamics/stepper.hpp"
#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {

/// The equation of motion of one step h of the generalised-alpha family (Newmark and HHT are special cases), solved for
/// the acceleration at its end,
///     a1 = a_free + W f1,  W = -(1-a_f) M*^-1 B,  M* = (1-a_m) M + (1-a_f) (gamma h C + beta h^2 K),
/// with the connector forces f1 there. M* is factored once. Holds the arrays of one thread.
class StepEquation {
public:
  virtual ~StepEquation() = default;

  /// a_free, n, of a step that begins with the motion's displacement, velocity and connector forces and the scheme's
  /// own `acceleration`, under the `load` P u_{1-a_f}.
  virtual void solve(const Motion& begin, const Eigen::VectorXd& acceleration, const Eigen::VectorXd& load,
                     Eigen::VectorXd& free) = 0;
  /// W, n x m.
  [[nodiscard]] virtual const Eigen::MatrixXd& response() const = 0;
  /// Of what a step adds to the acceleration, the part that its solution errs by, in the norm of M*; 0: rounding.
  [[nodiscard]] virtual double error() const { return 0.0; }
};

/// Throws InvalidInput where M* is not positive definite.
std::unique_ptr<StepEquation> make_step_equation(const LocallyNonlinearSystem& system, double step,
                                                 const AlphaParameters& parameters, FactorPrecision precision);

/// Cholesky factor of a system's matrix. Throws InvalidInput with `what` it is and the degree of freedom where it is
/// not positive definite.
SparseFactor factor_of(const SparseMatrix& matrix, const LocallyNonlinearSystem& system, const std::string& what);

}  // namespace kalfem
