// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <span>
#include <vector>

namespace kalfem {

/// L of P A P^T = L L^T, rounded to single precision. Solving for one right-hand side takes as long as L takes to be
/// read from memory, so that half the bytes are nearly half the time.
///
/// A solution is in error by about 6e-8 times the condition of A, which the caller has to find tolerable; it serves
/// best for corrections, A dx = b - A x with the residual in double precision.
class SinglePrecisionFactor {
public:
  /// Columns of L with one pattern below them are stored together: supernode s has the columns columns[s] to
  /// columns[s + 1], the rows rows[row_starts[s]] to rows[row_starts[s + 1]] of which the first are its own columns,
  /// and its values by columns from value_starts[s] on. Position j of the factor is row order[j] of A.
  struct Supernodes {
    std::vector<std::int64_t> columns, row_starts, value_starts, rows, order;
  };

  SinglePrecisionFactor(Supernodes supernodes, std::span<const double> values);

  /// x = A^-1 b, n. One thread at a time; allocates nothing.
  void solve(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution);

  [[nodiscard]] double bytes() const;  ///< memory of L [byte]

private:
  /// Of one supernode: its first column, its columns and rows, and where its values start.
  struct Shape {
    Eigen::Index first, width, height, start;
  };
  [[nodiscard]] std::size_t count() const { return supernodes_.columns.size() - 1; }
  [[nodiscard]] Shape shape(std::size_t s) const;

  Supernodes supernodes_;
  std::vector<float> values_;
  Eigen::VectorXf permuted_;    ///< what is solved for, in the order of the factor
  Eigen::VectorXf panel_rows_;  ///< of one supernode
};

}  // namespace kalfem
