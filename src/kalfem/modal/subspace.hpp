// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/modal/output_correlations.hpp"

namespace kalfem {

/// Block Hankel matrix of the correlations, with its singular values and vectors, and their sensitivity to each block
/// of the record: all that models of any order are made of.
///     H = [R_1 R_2 ... R_q; R_2 ... ; ...; R_p ... R_{p+q-1}] = U S V^T,   p = q = block_rows,
/// channels and references in units of their own root mean square.
struct Subspace {
  Eigen::Index channels = 0, block_rows = 0, blocks = 0;
  std::vector<Eigen::Index> reference_rows;  ///< channels that are references
  Eigen::MatrixXd left;                      ///< U, all columns: m x m with m = channels block_rows
  Eigen::VectorXd values;                    ///< S, as many as the smaller side, descending
  Eigen::MatrixXd right;                     ///< V, all columns: n x n with n = references block_rows
  Eigen::MatrixXd forward;                   ///< U^T dH V_1 of all blocks, one below the other: (blocks m) x max_order
  Eigen::MatrixXd reverse;  ///< V^T dH^T U_1 of all blocks, one below the other: (blocks n) x max_order

  [[nodiscard]] Eigen::Index references() const { return static_cast<Eigen::Index>(reference_rows.size()); }
  [[nodiscard]] Eigen::Index rows() const { return left.rows(); }
  [[nodiscard]] Eigen::Index columns() const { return right.rows(); }
  [[nodiscard]] Eigen::Index max_order() const { return forward.cols(); }

  /// First-order deviation of the space of the first `order` left singular vectors, orthogonal to it: dU = U_2 F with
  ///     F_ij = (s_j u_i^T dH v_j + s_i u_j^T dH v_i) / (s_j^2 - s_i^2),   i > order >= j,
  /// F of all blocks, one below the other: blocks (m - order) x order. What moves the vectors within the space changes
  /// the basis of a model and none of its modes.
  [[nodiscard]] Eigen::MatrixXd deviations(Eigen::Index order) const;
};

/// `scale`: root mean square of each channel.
Subspace make_subspace(const OutputCorrelations& correlations, Eigen::Index block_rows, Eigen::Index max_order,
                       const Eigen::VectorXd& scale, const std::vector<Eigen::Index>& references, int threads);

}  // namespace kalfem
