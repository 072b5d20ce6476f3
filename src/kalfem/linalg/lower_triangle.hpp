#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cstdint>
#include <vector>

namespace kalfem {

/// The lower triangle of a symmetric matrix by columns, with 64-bit indices: those of its factor may exceed 32 bits
/// where its own do not.
struct LowerTriangle {
  explicit LowerTriangle(const Eigen::SparseMatrix<double>& matrix) : size(matrix.rows()), diagonal(matrix.diagonal()) {
    starts.push_back(0);
    rows.reserve(static_cast<std::size_t>(matrix.nonZeros() / 2 + size) + 1);  // never without memory: CHOLMOD
    values.reserve(rows.capacity());                                           // refuses null pointers
    for (Eigen::Index column = 0; column < size; ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it)
        if (it.row() >= column) {
          rows.push_back(it.row());
          values.push_back(it.value());
        }
      starts.push_back(static_cast<std::int64_t>(rows.size()));
    }
  }

  [[nodiscard]] bool same_pattern(const LowerTriangle& other) const {
    return starts == other.starts && rows == other.rows;
  }

  Eigen::Index size;
  Eigen::VectorXd diagonal;
  std::vector<std::int64_t> starts, rows;
  std::vector<double> values;
};

}  // namespace kalfem
