// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/modal/modal_options.hpp"
#include "kalfem/modal/output_correlations.hpp"

namespace kalfem {

/// Block Hankel matrix of the correlations, with its singular values and vectors, and their sensitivity to each block
/// of the record: all that models of any order are made of.
///     H = [R_1 R_2 ... R_q; R_2 ... ; ...; R_p ... R_{p+q-1}],   H B = U S V^T,   p = q = block_rows,
/// channels and references in units of their own root mean square. By covariance B = 1. By data B B^T = T^-1, T the
/// block Toeplitz matrix of the references' correlations, that is, the covariance of the past: U S are then the
/// principal components of the future's projection onto the past [OM96], without the data matrix.
struct Subspace {
  Eigen::Index channels = 0, block_rows = 0, blocks = 0;
  std::vector<Eigen::Index> reference_rows;  ///< channels that are references
  Eigen::MatrixXd left;                      ///< U, all columns: m x m with m = channels block_rows
  Eigen::VectorXd values;                    ///< S, as many as the smaller side, descending
  Eigen::MatrixXd right;                     ///< V, all columns: n x n; by covariance n = references block_rows
  Eigen::MatrixXd first_lags;                ///< U^T times the first block column of H: m x references
  Eigen::MatrixXd forward;  ///< U^T d(H B) V_1 of all blocks, one below the other: (blocks m) x max_order
  Eigen::MatrixXd reverse;  ///< V^T d(H B)^T U_1 of all blocks, one below the other: (blocks n) x max_order

  [[nodiscard]] Eigen::Index references() const { return static_cast<Eigen::Index>(reference_rows.size()); }
  [[nodiscard]] Eigen::Index rows() const { return left.rows(); }
  [[nodiscard]] Eigen::Index columns() const { return right.rows(); }
  [[nodiscard]] Eigen::Index max_order() const { return forward.cols(); }

  /// First-order deviation of the space of the first `order` left singular vectors, orthogonal to it: dU = U_2 F with
  ///     F_ij = (s_j u_i^T d(HB) v_j + s_i u_j^T d(HB) v_i) / (s_j^2 - s_i^2),   i > order >= j,
  /// F of all blocks, one below the other: blocks (m - order) x order. What moves the vectors within the space changes
  /// the basis of a model and none of its modes.
  [[nodiscard]] Eigen::MatrixXd deviations(Eigen::Index order) const;
};

/// `scale`: root mean square of each channel. By data the largest order is no more than the combinations of past
/// outputs that move.
Subspace make_subspace(const OutputCorrelations& correlations, SubspaceMethod method, Eigen::Index block_rows,
                       Eigen::Index max_order, const Eigen::VectorXd& scale,
                       const std::vector<Eigen::Index>& references, int threads);

}  // namespace kalfem
