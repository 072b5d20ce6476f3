#pragma once

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/reduction/partition.hpp"

namespace kalfem {

/// Shapes that make up for the fixed-interface modes Phi that were left out [DNW97]: what the interior does
/// quasi-statically under the inertia forces of unit boundary accelerations, less the kept modes' part of it,
///     X = (1 - Phi Phi^T M_ii) K_ii^-1 (M_ii Psi + M_ib),
/// made mass-normalised and uncoupled, so that they read as further modes (vectors n_i x at most n_b, values
/// [(rad/s)^2] above those of the kept modes). Columns that add nothing are dropped: none are left where all modes are
/// kept.
LowestModes augmentation_vectors(const Partition& parts, const SparseMatrix& mass_ib,
                                 const Eigen::MatrixXd& constraint_modes, const Eigen::MatrixXd& kept,
                                 const SparseFactor& stiffness);

}  // namespace kalfem
