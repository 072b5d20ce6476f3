// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cstddef>
#include <vector>

namespace kalfem {

/// Asks the kernel to move memory that is read again and again onto pages of 2 MB: the processor then looks up an
/// address for each of these and not for every 4 kB. To be called once the memory is filled. What does not fill a large
/// page stays where it is, and so does all of it where the kernel cannot (Linux before 6.1, other systems).
void move_to_large_pages(const void* data, std::size_t bytes);

template <class Number>
void move_to_large_pages(const std::vector<Number>& numbers) {
  move_to_large_pages(numbers.data(), numbers.size() * sizeof(Number));
}

template <class Matrix>
void move_to_large_pages(const Eigen::PlainObjectBase<Matrix>& matrix) {
  move_to_large_pages(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar));
}

inline void move_to_large_pages(const Eigen::SparseMatrix<double>& matrix) {
  const auto entries = static_cast<std::size_t>(matrix.nonZeros());
  move_to_large_pages(matrix.valuePtr(), entries * sizeof(double));
  move_to_large_pages(matrix.innerIndexPtr(), entries * sizeof(int));
}

}  // namespace kalfem
