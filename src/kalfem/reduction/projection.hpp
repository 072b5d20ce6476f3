// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/linalg/long_vectors.hpp"
#include "kalfem/reduction/partition.hpp"

namespace kalfem {

/// In place of the columns X D, with a diagonal D: an M-orthonormal basis of what they span. Directions of which less
/// than a hundred-thousandth of the columns' unit size is left beside the others are dropped.
void orthonormalise(LongVectors& X, const Eigen::VectorXd& scale, const SparseMatrix& mass);

/// Rayleigh-Ritz: in place of independent columns X their mass-normalised combinations between which K and M have no
/// coupling. Returns the values of these [(rad/s)^2], ascending.
Eigen::VectorXd uncouple(LongVectors& X, const SparseMatrix& stiffness, const SparseMatrix& mass);

/// sqrt(lambda) / 2 pi [Hz]; negative values count as 0.
Eigen::VectorXd natural_frequencies(const Eigen::VectorXd& values);

/// (A + A^T) / 2.
Eigen::MatrixXd symmetric(const Eigen::MatrixXd& matrix);

/// T = [I 0 0; Psi Phi_1 Phi_2], n x r, its rows in the order of the full model, of interior shapes of n_i rows each.
/// These go over into T a few columns at a time, so that no more are there twice, and are none afterwards.
std::unique_ptr<LongVectors> transformation(const Partition& parts, const std::vector<LongVectors*>& shapes);

/// The model in the coordinates q of z = T q with T = [I 0; Psi Phi]: constraint modes Psi, in equilibrium in the
/// interior, and mass-normalised modes Phi of the interior with these values [(rad/s)^2]. So the last block of the mass
/// is the identity, that of the stiffness diagonal, and the stiffness has no coupling between the two. The damping is
/// T^T (C + C_m) T, without ever forming the modal damping C_m. Grounds, points and gauges stay empty.
LinearModel projected_model(const LinearModel& model, const LongVectors& T, const Eigen::VectorXd& values);

/// Grounds, points, gauges and names of the model's reduced form.
void carry_over(const LinearModel& model, const Eigen::MatrixXd& T, std::vector<std::string> names,
                LinearModel& reduced);

/// The boundary and what is kept beside it, each name once.
std::vector<std::string> joined(const std::vector<std::string>& boundary, const std::vector<std::string>& also_kept);

}  // namespace kalfem
