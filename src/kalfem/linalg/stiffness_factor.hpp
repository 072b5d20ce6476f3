// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <optional>
#include <span>
#include <string>

#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {

/// What solves K u = f for a stiffness K that may leave motions free:
///   - K is safely positive definite: its own factor;
///   - K is singular: the factor of K + shift M;
///   - K is singular and its motions without strain are known: the factor of K held at as many degrees of freedom,
///     whose reactions vanish under loads in equilibrium [FG98].
struct StiffnessFactor {
  SparseFactor factor;
  double shift = 0.0;                   ///< [(rad/s)^2]
  Eigen::MatrixXd rigid_modes = {};     ///< R, n x r, all motions without strain, R^T M R = 1; empty in the first two
  Eigen::MatrixXd rigid_momentum = {};  ///< M R

  /// Whether u = K^-1 f exists for every f.
  [[nodiscard]] bool regular() const { return shift == 0.0 && rigid_modes.cols() == 0; }

  /// (K + shift M)^-1 F, n x k; with rigid modes the displacements of K U = (1 - M R R^T) F with R^T M U = 0.
  /// F and U may be the same.
  void respond(const Eigen::Ref<const Eigen::MatrixXd>& loads, Eigen::Ref<Eigen::MatrixXd> displacements) const;
};

/// Factors K, or, where it is singular or a pivot is so small that it may be (below 1e-10 K_jj), K + s M with s a
/// hundred-millionth of the median of K_jj / M_jj: near the lowest elastic eigenvalues of a finite-element model, and
/// far above the rounding of its highest ones. Throws InvalidInput where K is indefinite or a motion has neither
/// stiffness nor mass; the message calls the degree of freedom by its name, where names are given.
/// `order`: of the factor of a matrix with K's pattern, to be used again.
StiffnessFactor factor_stiffness(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                                 std::span<const std::string> names = {}, const EliminationOrder& order = {});

/// Factors K held against `motions`, n x r: independent ones without strain. Nothing where that does not leave K safely
/// positive definite, because there are further motions without strain or K is indefinite, and where a motion has no
/// mass.
std::optional<StiffnessFactor> factor_held(const Eigen::SparseMatrix<double>& stiffness,
                                           const Eigen::SparseMatrix<double>& mass, const Eigen::MatrixXd& motions);

/// The diagonal of springs, as stiff as K_jj, of a statically determinate support against `motions`, n x r: at the
/// degrees of freedom that hold these best.
Eigen::VectorXd supports(const Eigen::SparseMatrix<double>& stiffness, const Eigen::MatrixXd& motions);

/// Whether phi^T K phi <= 1e-12 sum_j K_jj phi_j^2: the strain energy is rounding of the energies that cancel in it.
bool moves_rigidly(const Eigen::SparseMatrix<double>& stiffness, const Eigen::Ref<const Eigen::VectorXd>& shape);

}  // namespace kalfem
