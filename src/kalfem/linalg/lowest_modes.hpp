// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <optional>

#include "kalfem/linalg/stiffness_factor.hpp"

namespace kalfem {

/// How it is made sure that no eigenpair below the highest returned one is missing.
enum class ModeCheck {
  automatic,  ///< Sturm up to 3000 unknowns, a fresh block above
  sturm,  ///< negative pivots of K - lambda M = L D L^T are counted: certain; costs a simplicial factorisation, much
          ///< slower than the supernodal one for large models
  block,  ///< a random block is iterated in the complement of what was found until its lowest value is known to 5 %;
          ///< costs about 40 back-solves, and finds also what exceeds the multiplicity that the first block could hold
  none
};

/// Which eigenpairs of K phi = lambda M phi are wanted: so many of the lowest, or all below a limit, or both (whichever
/// is reached first).
struct LowestModesOptions {
  std::optional<Eigen::Index> count = {};
  std::optional<double> below = {};  ///< lambda limit [(rad/s)^2]
  Eigen::Index at_least = 0;         ///< so many also above the limit
  double tolerance = 1e-10;  ///< |(K + s M)^-1 M phi - theta phi|_M <= tolerance theta, theta = 1 / (lambda + s)
  ModeCheck check = ModeCheck::automatic;
};

/// Eigenpairs in ascending order, Phi^T M Phi = 1; the largest entry of each vector is positive.
struct LowestModes {
  Eigen::VectorXd values;      ///< lambda [(rad/s)^2]; rigid-body modes are exactly 0
  Eigen::MatrixXd vectors;     ///< n x k
  std::optional<double> next;  ///< lowest eigenvalue that was not asked for, to about 1 %; none: there is no other
  Eigen::Index solves = 0;     ///< back-solves that it took
};

/// Lowest eigenpairs of large sparse symmetric K (positive semi-definite) and M (positive definite or semi-definite) by
/// block Lanczos on (K + s M)^-1 M [GLS94]; small problems, or nearly all pairs of a larger one, by the dense solver.
///
/// Rigid-body modes, see moves_rigidly(), are cleaned to exactly 0. The start vectors are fixed, so the result is
/// reproducible.
/// Throws InvalidInput where more pairs are asked for than there are, or they cannot be reached.
LowestModes lowest_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                         const LowestModesOptions& options);
LowestModes lowest_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                         const StiffnessFactor& factored, const LowestModesOptions& options);

}  // namespace kalfem
