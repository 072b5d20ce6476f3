#pragma once

#include <optional>

#include "kalfem/system/locally_nonlinear_system.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

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
