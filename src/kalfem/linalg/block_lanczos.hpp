// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <memory>
#include <random>

#include "kalfem/linalg/long_vectors.hpp"
#include "kalfem/linalg/stiffness_factor.hpp"

namespace kalfem {

/// Rayleigh-Ritz pairs of a Krylov space, largest value first.
struct RitzPairs {
  Eigen::VectorXd values;     ///< theta, about 1 / (lambda + shift)
  Eigen::VectorXd residuals;  ///< |A^-1 M x - theta x| in the norm of M
  Eigen::MatrixXd vectors;    ///< coefficients of x over the basis
};

/// Block Lanczos with full reorthogonalisation and thick restart [GLS94, WS00] for A^-1 M, which is symmetric in the
/// inner product of M. A Krylov space that starts with a block finds eigenvalues of a multiplicity up to its width,
/// and solves for the whole block at once. M may be semi-definite: the space stays in the range of A^-1 M.
class BlockLanczos {
public:
  /// `factor` of A and `mass` M, n x n, are kept by reference; the basis has at most `capacity` columns at a time. With
  /// rigid modes in the factor, A^-1 is its respond(), and the space M-orthogonal to them.
  BlockLanczos(const StiffnessFactor& factor, const Eigen::SparseMatrix<double>& mass, Eigen::Index width,
               Eigen::Index capacity);

  /// Applies the operator to the last block. False where there is none: the space is invariant.
  bool step();
  /// Puts a random block, orthogonal to the basis, in place of the last one. False where nothing is left.
  bool restart_at_random();
  /// Shrinks the basis to its `keep` leading Ritz vectors.
  void compress(const RitzPairs& pairs, Eigen::Index keep);
  void set_capacity(Eigen::Index capacity) { basis_->reserve(capacity); }

  [[nodiscard]] RitzPairs pairs() const;
  [[nodiscard]] Eigen::MatrixXd vectors(const RitzPairs& pairs, Eigen::Index count) const;
  [[nodiscard]] Eigen::Index size() const { return size_; }  ///< columns of the basis to which A^-1 M was applied
  [[nodiscard]] bool full() const { return size_ + 2 * width_ > basis_->capacity(); }
  [[nodiscard]] Eigen::Index solves() const { return solves_; }

private:
  void apply();
  Eigen::MatrixXd normalise(double shortest);
  void attach(Eigen::Index near, Eigen::Index columns, Eigen::MatrixXd& projections, Eigen::MatrixXd& triangle);

  const StiffnessFactor& factor_;
  const Eigen::SparseMatrix<double>& mass_;
  Eigen::Index width_;
  Eigen::Index size_ = 0;  ///< columns to which the operator was applied; the last block follows them
  Eigen::Index last_ = 0;  ///< width of the last block
  Eigen::Index solves_ = 0;
  std::unique_ptr<LongVectors> basis_;   ///< Q, M-orthonormal
  Eigen::MatrixXd block_;                ///< V, the last block or what becomes the next one, n x width
  Eigen::MatrixXd mass_weighted_modes_;  ///< M V
  Eigen::MatrixXd scratch_;              ///< of their size: at millions of rows an allocation a step costs much
  Eigen::MatrixXd projected_;            ///< Q^T M A^-1 M Q, of the first `size_` columns
  Eigen::Index coupled_ = 0;             ///< first column of the basis with which the last block is coupled
  Eigen::MatrixXd coupling_;             ///< last_ x size_: A^-1 M Q = Q projected + Q_last coupling
  std::mt19937 random_;
};

}  // namespace kalfem
