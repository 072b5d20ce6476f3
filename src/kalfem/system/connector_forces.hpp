// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

/// When the implicit solve for the connector forces counts as done.
struct ForceSolveOptions {
  double tolerance = 1e-8;    ///< stop when |last correction of f_j| <= tolerance (|f_j| + force_floor); Newton's next
                              ///< error is its square
  double force_floor = 1e-3;  ///< [N]
  int max_iterations = 60;    ///< Newton corrections, halvings included
};

/// How the solve ended: a value, counted by the caller.
struct ForceSolveOutcome {
  bool converged = true;
  bool finite = true;
  int iterations = 0;
};

/// The connectors of a system at N points at once: forces of all laws, and the small implicit solve of size m that
/// every time stepping needs. Owns its arrays: one thread at a time, no allocation once the number of points has been
/// seen.
///
/// A solver knows the connectors' motion up to their own forces, k = k_free + H f with k = [d; d'; d''] (3m) and H
/// constant (3m x m), and asks for the f with f = law(k_free + H f). All points take Newton corrections until the last
/// of them is done, shortened where a residual grows; where that does not end, each connector in turn by bisection.
///
/// The forces at several instants, equally far apart, may be solved for together: below m then counts the connectors at
/// all instants, those of the first one before those of the second. Internal states go from one to the next; what they
/// carry over is left out of Newton's tangents.
class ConnectorForces {
public:
  explicit ConnectorForces(const LocallyNonlinearSystem& system, ForceSolveOptions options = {},
                           Eigen::Index instants = 1);
  ConnectorForces(ConnectorForces&&) noexcept;
  ConnectorForces& operator=(ConnectorForces&&) noexcept;
  ~ConnectorForces();

  /// Sets the number of points; parameters return to the connectors' own values.
  void resize(Eigen::Index points);
  [[nodiscard]] Eigen::Index points() const { return force_.rows(); }

  /// Values of one law parameter at all points (unknown parameters at sigma points), to be set before a solve and asked
  /// for anew to be set again.
  auto parameter(Eigen::Index connector, Eigen::Index index) {
    const auto column = first_parameter_[static_cast<std::size_t>(connector)] + index;
    parameter_changed_[static_cast<std::size_t>(column)] = 1;
    return parameters_.col(column);
  }

  // Motion is stored N x 3m with columns [d_1 .. d_m, d'_1 .. d'_m, d''_1 .. d''_m].
  Eigen::ArrayXXd& free_motion() { return free_motion_; }    ///< k_free at the interval's end, input
  Eigen::ArrayXXd& begin_motion() { return begin_motion_; }  ///< k at the interval's begin, N x 2m used, input
  Eigen::ArrayXXd& begin_states() { return begin_states_; }  ///< s at the interval's begin, N x states, input
  Eigen::ArrayXXd& force() { return force_; }                ///< f, N x m: first guess in, solution out
  [[nodiscard]] const Eigen::ArrayXXd& motion() const { return motion_; }  ///< k = k_free + H f, output
  [[nodiscard]] const Eigen::ArrayXXd& states() const { return states_; }  ///< s at the end, output

  /// Solves f = law(k_free + H f) over an interval of the given duration (0: at an instant, states stay), the one up to
  /// the first of several instants.
  ForceSolveOutcome solve(const Eigen::MatrixXd& compliance, double duration);

private:
  class Solver;

  std::vector<Connector> connectors_;  ///< laws and their own parameters; the rest is empty
  ForceSolveOptions options_;
  Eigen::Index instants_;
  std::vector<Eigen::Index> first_parameter_;  ///< of each connector, a column of parameters_
  std::vector<char> parameter_changed_;        ///< since the last solve
  Eigen::ArrayXXd parameters_, free_motion_, begin_motion_, motion_, begin_states_, states_, force_;
  std::unique_ptr<Solver> solver_;
};

/// Column of `to` += factor * column of `from`, a column that need not stand on a register's boundary; nothing where
/// the factor is zero, whatever `from` holds.
void add_scaled(double factor, const Eigen::ArrayXXd& from, Eigen::Index from_column, Eigen::ArrayXXd& to,
                Eigen::Index to_column);

}  // namespace kalfem
