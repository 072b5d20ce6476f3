// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/system/locally_nonlinear_system.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

/// A system in the coordinates of all its undamped modes, z = Phi q with K Phi = M Phi Omega^2, Phi^T M Phi = 1:
///     q'' + Phi^T (C + C_m) Phi q' + Omega^2 q + sum_j (Phi^T b_j) f_j = Phi^T p.
/// Without dashpots that join the modes the equations are single oscillators. Frequencies and terms of the damping that
/// are rounding are zero exactly: rigid-body modes, and modes that do not act on each other.
struct ModalCoordinates {
  /// Dense, for systems of moderate size. Throws InvalidInput where M is not positive definite.
  explicit ModalCoordinates(const LocallyNonlinearSystem& physical);

  LocallyNonlinearSystem system;        ///< in q
  Eigen::MatrixXd shapes;               ///< Phi, n x n
  Eigen::MatrixXd mass_weighted_modes;  ///< M Phi, n x n: q = mass-weighted modes^T z
};

/// The same outputs as functions of q, z = Phi q.
OutputMap outputs_of_modes(const OutputMap& of_motion, const Eigen::MatrixXd& shapes);

/// The same system in other coordinates, in which modal damping is sparse. The motion is split into the damped modes'
/// amplitudes and a remainder that is M-orthogonal to them,
///     z = r + Phi eta,   Phi^T M r = 0,   q = [r; eta],
/// and since Phi are modes of M and K,
///     diag(M, 1) q'' + diag(C, D) q' + diag(K, Omega^2) q = [(1 - M Phi Phi^T) p; Phi^T p]
/// for every load p. A time step then costs no product with the n x p matrix of modes.
struct DampedModeSplit {
  LocallyNonlinearSystem system;        ///< in q, n + p; its modal_damping is empty
  Eigen::MatrixXd shapes;               ///< Phi, n x p
  Eigen::MatrixXd mass_weighted_modes;  ///< M Phi, n x p

  /// q of a motion z.
  [[nodiscard]] Eigen::VectorXd split(const Eigen::VectorXd& motion) const;
  /// z = r + Phi eta.
  [[nodiscard]] Eigen::VectorXd merge(const Eigen::VectorXd& coordinates) const;
  /// The same outputs of q.
  [[nodiscard]] OutputMap outputs(const OutputMap& of_motion) const;
};

/// Nothing where the system has no modal damping, where its damped modes are not modes of M and K, or where dashpots
/// join them to the remainder (C Phi is not M Phi times a diagonal).
std::optional<DampedModeSplit> split_damped_modes(const LocallyNonlinearSystem& system);

}  // namespace kalfem
