// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cstdint>
#include <vector>

#include "kalfem/base/hash.hpp"

namespace kalfem {

/// The upper triangle of a symmetric matrix by columns, rows ascending, which CHOLMOD turns into its own form with one
/// copy. With 64-bit indices: those of the factor may exceed 32 bits where the matrix's own do not. `springs`, n x 1,
/// are added to the diagonal, where they are given, whether the matrix has entries there or not.
struct UpperTriangle {
  explicit UpperTriangle(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& springs = {})
      : size(matrix.rows()), diagonal(matrix.diagonal()) {
    if (springs.size() > 0) diagonal += springs;
    starts.push_back(0);
    rows.reserve(static_cast<std::size_t>(matrix.nonZeros() / 2 + size) + 1);  // never without memory: CHOLMOD
    values.reserve(rows.capacity());                                           // refuses null pointers
    for (Eigen::Index column = 0; column < size; ++column) {
      bool has_diagonal = springs.size() == 0;
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it && it.row() <= column; ++it) {
        rows.push_back(it.row());
        values.push_back(it.row() == column ? diagonal[column] : it.value());
        has_diagonal |= it.row() == column;
      }
      if (!has_diagonal) {
        rows.push_back(column);
        values.push_back(diagonal[column]);
      }
      starts.push_back(static_cast<std::int64_t>(rows.size()));
    }
  }

  /// A number that another pattern does not have.
  [[nodiscard]] std::uint64_t pattern() const {
    Hash hash;
    for (const auto* numbers : {&starts, &rows})
      hash.add({reinterpret_cast<const char*>(numbers->data()), numbers->size() * sizeof(std::int64_t)});
    return hash.value();
  }

  Eigen::Index size;
  Eigen::VectorXd diagonal;
  std::vector<std::int64_t> starts, rows;
  std::vector<double> values;
};

}  // namespace kalfem
