#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>

#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {

/// Eigenpairs of K phi = lambda M phi by dense solvers, ascending, Phi^T M Phi = 1.
struct DensePairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// All pairs with finite lambda. Where M is positive definite, of the pencil itself. Else of G = L^T E^T A^-1 E L with
/// A = K + s M (`shifted`), E the columns of the identity that have mass and L L^T the mass there: G w = w / (lambda +
/// s), phi = (lambda + s) A^-1 E L w; its size is the number of degrees of freedom with mass.
DensePairs dense_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                       const SparseFactor& shifted, double shift);

}  // namespace kalfem
