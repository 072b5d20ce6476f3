// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/complex_factor.hpp"

#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

/// A chain of `size` springs with diagonal entries of their own.
ComplexSparseMatrix chain(Index size, Complex diagonal, Complex beside) {
  std::vector<Eigen::Triplet<Complex, std::int64_t>> entries;
  for (Index i = 0; i < size; ++i) {
    entries.emplace_back(i, i, diagonal + 0.1 * static_cast<double>(i));
    if (i + 1 == size) continue;
    entries.emplace_back(i, i + 1, beside);
    entries.emplace_back(i + 1, i, beside);
  }
  ComplexSparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

TEST(ComplexFactor, SolvesEachMatrixOfItsPattern) {
  const MatrixXcd right = MatrixXcd::Random(50, 3);
  ComplexFactor factor(chain(50, {2.0, 0.1}, -1.0));
  for (const Complex diagonal : {Complex(2.0, 0.1), Complex(-1.5, 0.3), Complex(0.0, 4.0)}) {
    const auto matrix = chain(50, diagonal, {-1.0, 0.2});
    ASSERT_TRUE(factor.factor(matrix));
    const MatrixXcd solution = factor.solve(right);
    EXPECT_LT((matrix * solution - right).norm(), 1e-12 * right.norm());  // rounding
  }
}

TEST(ComplexFactor, TellsASingularMatrix) {
  ComplexFactor factor(chain(2, 1.0, -1.0));
  auto singular = chain(2, 1.0, -1.0);
  singular.coeffRef(1, 1) = 1.0;
  EXPECT_FALSE(factor.factor(singular));
  EXPECT_TRUE(factor.factor(chain(2, 3.0, -1.0)));
}

TEST(ComplexFactor, RefusesAMatrixThatIsNotSquare) {
  EXPECT_THROW(ComplexFactor(ComplexSparseMatrix(2, 3)), InvalidInput);
}

}  // namespace
}  // namespace kalfem
