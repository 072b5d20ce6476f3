#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <optional>
#include <span>
#include <string>

#include "kalfem/linalg/sparse_factor.hpp"

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

/// The factor of K + shift M. The shift is 0 where K is safely positive definite: the factor serves for statics then.
struct ShiftedStiffness {
  SparseFactor factor;
  double shift = 0.0;  ///< [(rad/s)^2]
};

/// Factors K, or, where it is singular or a pivot is so small that it may be (below 1e-10 K_jj), K + s M with s a
/// hundred-millionth of the median of K_jj / M_jj: near the lowest elastic eigenvalues of a finite-element model, and
/// far above the rounding of its highest ones. Throws InvalidInput where K is indefinite or a motion has neither
/// stiffness nor mass; the message calls the degree of freedom by its name, where names are given.
/// `order`: of the factor of a matrix with K's pattern, to be used again.
ShiftedStiffness factor_stiffness(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                                  std::span<const std::string> names = {}, const EliminationOrder& order = {});

/// Whether phi^T K phi <= 1e-12 sum_j K_jj phi_j^2: the strain energy is rounding of the energies that cancel in it.
bool moves_rigidly(const Eigen::SparseMatrix<double>& stiffness, const Eigen::Ref<const Eigen::VectorXd>& shape);

/// Lowest eigenpairs of large sparse symmetric K (positive semi-definite) and M (positive definite or semi-definite) by
/// block Lanczos on (K + s M)^-1 M [GLS94]; small problems, or nearly all pairs of a larger one, by the dense solver.
///
/// Rigid-body modes, see moves_rigidly(), are cleaned to exactly 0. The start vectors are fixed, so the result is
/// reproducible.
/// Throws InvalidInput where more pairs are asked for than there are, or they cannot be reached.
LowestModes lowest_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                         const LowestModesOptions& options);
LowestModes lowest_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                         const ShiftedStiffness& shifted, const LowestModesOptions& options);

}  // namespace kalfem
