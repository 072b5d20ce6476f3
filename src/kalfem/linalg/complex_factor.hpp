// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <complex>
#include <cstdint>
#include <memory>

namespace kalfem {

/// In 64-bit indices: those of the factor may exceed 32 bits where the matrix' own do not.
using ComplexSparseMatrix = Eigen::SparseMatrix<std::complex<double>, Eigen::ColMajor, std::int64_t>;

/// Sparse LU factor of complex matrices, n x n, whose pattern is symmetric (UMFPACK [Dav04], nested dissection, pivots
/// on the diagonal where they are not small). All matrices of one factor have the same pattern, which is analysed once.
/// One thread at a time.
class ComplexFactor {
public:
  /// Analyses the pattern of the matrix. Throws InvalidInput where it is not square.
  explicit ComplexFactor(const ComplexSparseMatrix& matrix);
  ~ComplexFactor();
  ComplexFactor(ComplexFactor&&) noexcept;
  ComplexFactor& operator=(ComplexFactor&&) noexcept;

  /// Factors a matrix with that pattern, which must live as long as solve() is called. False where it is singular.
  [[nodiscard]] bool factor(const ComplexSparseMatrix& matrix);

  /// X = A^-1 B, n x k, of the matrix that was factored last.
  [[nodiscard]] Eigen::MatrixXcd solve(const Eigen::MatrixXcd& right_side) const;

private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace kalfem
