// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <new>

#include "kalfem/linalg/long_vectors.hpp"
#include "on_ranks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

TEST(DistributedVectors, AreMadeWhereRanksWork) {
  EXPECT_EQ(dynamic_cast<VectorsInMemory*>(make_long_vectors(100).get()), nullptr);
}

// Rank 0 has no such limit.
TEST(DistributedVectors, RefuseRoomThatAWorkerHasNot) {
  constexpr Index rows_of_a_rank = 1 << 16, columns = test::most_memory_of_a_worker / rows_of_a_rank / 8;
  const auto vectors = make_long_vectors(rows_of_a_rank * test::number_of_ranks());
  EXPECT_THROW(vectors->reserve(columns), std::bad_alloc);
}

TEST(DistributedVectors, AreThereAfterOthersFoundNoRoom) {
  const MatrixXd columns = MatrixXd::Random(1001, 3);
  const auto vectors = make_long_vectors(1001);
  vectors->reserve(3);
  vectors->put(0, columns);
  EXPECT_THROW(make_long_vectors(1000000)->reserve(Index{1} << 30), std::bad_alloc);
  EXPECT_EQ(vectors->combination(MatrixXd::Identity(3, 3)), columns);
}

TEST(DistributedVectors, LiveSideBySide) {
  const MatrixXd columns = MatrixXd::Random(1001, 6);
  std::vector<std::unique_ptr<LongVectors>> all;
  for (Index first = 0; first < 6; first += 2) {
    all.push_back(make_long_vectors(1001));
    all.back()->reserve(2);
    all.back()->put(0, columns.middleCols(first, 2));
  }
  all.erase(all.begin() + 1);
  EXPECT_EQ(all[0]->combination(MatrixXd::Identity(2, 2)), columns.leftCols(2));
  EXPECT_EQ(all[1]->combination(MatrixXd::Identity(2, 2)), columns.rightCols(2));
}

}  // namespace
}  // namespace kalfem
