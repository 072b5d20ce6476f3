// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/large_pages.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace kalfem {
namespace {

TEST(LargePages, KeepWhatTheMemoryHolds) {
  for (const std::size_t count : {0, 1, 1 << 10, 1 << 18, (1 << 20) + 3}) {  // 8 MB and 24 bytes at most
    std::vector<double> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0.5);
    const auto* place = numbers.data();
    move_to_large_pages(numbers);
    EXPECT_EQ(numbers.data(), place);
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(numbers[i], static_cast<double>(i) + 0.5) << count;
  }
}

TEST(LargePages, OfMatrices) {
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Random(1 << 19, 1);
  const Eigen::SparseMatrix<double> sparse = dense.sparseView();
  Eigen::MatrixXd moved = dense;
  Eigen::SparseMatrix<double> moved_sparse = sparse;
  move_to_large_pages(moved);
  move_to_large_pages(moved_sparse);
  EXPECT_EQ(moved, dense);
  EXPECT_EQ((moved_sparse - sparse).norm(), 0.0);
}

}  // namespace
}  // namespace kalfem
