#pragma once

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

}  // namespace kalfem
