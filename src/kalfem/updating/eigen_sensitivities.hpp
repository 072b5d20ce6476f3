// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// Lowest modes K Phi = M Phi Lambda, Phi^T M Phi = 1, with the matrices they are of; all kept by reference. K may be
/// singular: rigid-body modes have lambda = 0 like others.
struct SolvedEigenproblem {
  const SparseMatrix& stiffness;   ///< K, n x n
  const SparseMatrix& mass;        ///< M, n x n
  const StiffnessFactor& shifted;  ///< the factor of K + s M with which the modes were found
  const LowestModes& modes;
};

/// Consecutive modes whose eigenvalues count as one: only the space they span is determined, not its basis.
struct ModeGroup {
  Eigen::Index first = 0;
  Eigen::Index size = 1;
  [[nodiscard]] bool has(Eigen::Index mode) const { return mode >= first && mode < first + size; }
};

/// Groups of eigenvalues in ascending order; neighbours are of one group where lambda_j - lambda_i <= tolerance
/// lambda_j.
std::vector<ModeGroup> group_modes(const Eigen::VectorXd& values, double tolerance);

/// D = Phi_G^T (dK - lambda dM) Phi_G, size x size [(rad/s)^2 per unit of the parameter]. Of a single mode it is d
/// lambda [FK68]; of a repeated eigenvalue the eigenvalues of D are the rates at which it splits [Oja88]. The diagonal
/// holds the derivatives of phi_k^T K phi_k / phi_k^T M phi_k, also where the values differ; their sum is
/// differentiable always, in all parameters at once.
Eigen::MatrixXd projected_derivative(const LowestModes& modes, const ModeGroup& group,
                                     const ModelDerivative& derivative);

/// A rotation Q, g x g, that makes all Q^T D_p Q as diagonal as one rotation can, each D_p (g x g, symmetric) counted
/// by its relative size: by plane rotations through the best angle of all matrices together [CS96]. Where the D_p
/// commute it diagonalises all of them: in the basis Phi_G Q the modes of a group are those that each parameter splits.
Eigen::MatrixXd joint_eigenbasis(std::vector<Eigen::MatrixXd> matrices);

struct EigenSensitivityOptions {
  double tolerance = 1e-9;    ///< of the residual in the norm of (K + s M)^-1, relative to the right-hand side
  int most_iterations = 500;  ///< a few dozen are usual
};

/// dPhi_G per parameter, n x size, in the basis that does not rotate within the group, Phi_G^T M dPhi_G = -1/2 Phi_G^T
/// dM Phi_G. This is the derivative of the eigenvector of a group of one; of a larger group it describes how its space
/// moves, which is differentiable in all parameters at once.
///
/// The part along the other modes is their expansion [FK68]. The rest x solves (K - lambda M) x = -(dK - lambda dM) phi
/// in the complement of all modes, where K - lambda M is positive definite: by conjugate gradients preconditioned with
/// (K + s M)^-1, many right-hand sides at a time [Alv97]. So no matrix is factored beside the one that gave the modes,
/// where Nelson's method [Nel76] factors one a mode.
///
/// Nothing where an eigenvalue equal to the group's is missing among the modes: compute at least one group more than
/// is looked at.
std::optional<std::vector<Eigen::MatrixXd>> subspace_derivatives(const SolvedEigenproblem& problem,
                                                                 const ModeGroup& group,
                                                                 const std::vector<ModelDerivative>& derivatives,
                                                                 const EigenSensitivityOptions& options = {});

/// How the eigenpairs of a repeated eigenvalue part along one parameter.
struct SplitEigenpairs {
  Eigen::MatrixXd basis;                   ///< Q, g x g: the eigenvectors that are differentiable are Phi_G Q
  Eigen::VectorXd values;                  ///< d lambda, ascending
  std::optional<Eigen::MatrixXd> vectors;  ///< d(Phi_G Q), n x g; nothing where two d lambda are equal
};

/// Derivatives of the eigenpairs of a repeated eigenvalue along one parameter by Dailey's method [Dai89]: with D = Q
/// diag (lambda') Q^T and the basis that does not rotate, the rotation within the group follows from the second
/// derivative of the equation,
///     c_lk = phi_l^T [(d2K - lambda d2M) phi_k + 2 (dK - lambda dM) v_k - 2 lambda'_k dM phi_k] / (2 (lambda'_k -
///     lambda'_l)),
/// v_k the part of the derivative outside the group. `second` holds d2K and d2M (0 x 0 where they are zero). Nothing
/// where subspace_derivatives() has nothing.
std::optional<SplitEigenpairs> split_eigenpairs(const SolvedEigenproblem& problem, const ModeGroup& group,
                                                const ModelDerivative& derivative, const ModelDerivative& second,
                                                const EigenSensitivityOptions& options = {});

}  // namespace kalfem
