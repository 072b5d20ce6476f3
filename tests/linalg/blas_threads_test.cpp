// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/blas.hpp"

#include <gtest/gtest.h>

#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {
namespace {

TEST(BlasThreads, AreOneFromTheFirstFactorisationOn) {
  if (blas_threads() == 0) GTEST_SKIP() << "the BLAS library is not OpenBLAS";
  Eigen::SparseMatrix<double> identity(3, 3);
  identity.setIdentity();
  const SparseFactor factor(identity);
  EXPECT_EQ(blas_threads(), 1);
}

}  // namespace
}  // namespace kalfem
