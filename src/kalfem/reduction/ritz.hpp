#pragma once

#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {

/// M-orthonormal basis of what the columns span, n x at most their number. Directions of which less than a
/// hundred-thousandth of the columns' unit size is left beside the others are dropped.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, const Eigen::SparseMatrix<double>& mass);

/// Rayleigh-Ritz: the mass-normalised combinations of independent columns between which K and M have no coupling, and
/// their values [(rad/s)^2], ascending.
LowestModes uncoupled(const Eigen::MatrixXd& columns, const Eigen::SparseMatrix<double>& stiffness,
                      const Eigen::SparseMatrix<double>& mass);

}  // namespace kalfem
