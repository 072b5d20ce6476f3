// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/long_vectors.hpp"

#include <gtest/gtest.h>

#include <new>

#include "linalg/near.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using test::expect_near;

std::unique_ptr<LongVectors> vectors_of(const MatrixXd& columns, Index capacity) {
  auto vectors = make_long_vectors(columns.rows());
  vectors->reserve(capacity);
  vectors->put(0, columns);
  return vectors;
}

TEST(LongVectors, ComeBackAsTheyWerePut) {
  const MatrixXd columns = MatrixXd::Random(1001, 19), block = MatrixXd::Random(1001, 3);
  const auto vectors = vectors_of(columns, 20);
  vectors->put(5, block);
  MatrixXd expected = columns;
  expected.middleCols(5, 3) = block;
  EXPECT_EQ(vectors->columns(0, 19), expected);
}

TEST(LongVectors, AreMadeOfColumns) {
  const MatrixXd columns = MatrixXd::Random(1001, 19);
  const auto vectors = make_long_vectors(columns);
  EXPECT_EQ(vectors->rows(), 1001);
  EXPECT_EQ(vectors->capacity(), 19);
  EXPECT_EQ(vectors->columns(0, 19), columns);
  EXPECT_EQ(vectors->columns(3, 14), columns.middleCols(3, 11));
  EXPECT_EQ(vectors->columns(4, 4), MatrixXd(1001, 0));
  EXPECT_EQ(make_long_vectors(MatrixXd(1001, 0))->capacity(), 0);
}

TEST(LongVectors, AreTakenAway) {
  const MatrixXd columns = MatrixXd::Random(1001, 19);
  const auto vectors = make_long_vectors(columns);
  EXPECT_EQ(vectors->take(), columns);
  EXPECT_EQ(vectors->capacity(), 0);
  EXPECT_EQ(vectors->take(), MatrixXd(1001, 0));
}

TEST(LongVectors, HaveProductsWithABlock) {
  const MatrixXd columns = MatrixXd::Random(1001, 20), block = MatrixXd::Random(1001, 11);
  const auto vectors = make_long_vectors(columns);
  expect_near(vectors->products(4, 17, block), columns.middleCols(4, 13).transpose() * block);
  EXPECT_EQ(vectors->products(4, 4, block), MatrixXd(0, 11));
  EXPECT_EQ(vectors->products(4, 17, block.leftCols(0)), MatrixXd(13, 0));
}

TEST(LongVectors, AreProjectedOutOfABlock) {
  const MatrixXd columns = MatrixXd::Random(1001, 20), mass_weighted = MatrixXd::Random(1001, 11);
  const auto vectors = vectors_of(columns, 20);
  MatrixXd block = MatrixXd::Random(1001, 11);
  const MatrixXd coefficients = columns.middleCols(4, 13).transpose() * mass_weighted;
  const MatrixXd expected = block - columns.middleCols(4, 13) * coefficients;
  expect_near(vectors->project_out(4, 17, mass_weighted, block), coefficients);
  expect_near(block, expected);
}

TEST(LongVectors, LeaveABlockAsItIsWhereTheyAreNone) {
  const auto vectors = vectors_of(MatrixXd::Random(101, 4), 4);
  const MatrixXd before = MatrixXd::Random(101, 2);
  MatrixXd block = before;
  EXPECT_EQ(vectors->project_out(3, 3, before, block), MatrixXd(0, 2));
  EXPECT_EQ(block, before);
  MatrixXd no_columns(101, 0);
  EXPECT_EQ(vectors->project_out(0, 4, no_columns, no_columns), MatrixXd(4, 0));
}

TEST(LongVectors, AreCombined) {
  const MatrixXd columns = MatrixXd::Random(1001, 20), weights = MatrixXd::Random(18, 10);
  expect_near(vectors_of(columns, 20)->combination(weights), columns.leftCols(18) * weights);
}

// More rows than are combined at a time.
TEST(LongVectors, AreCombinedInTheirPlace) {
  const MatrixXd columns = MatrixXd::Random(30001, 9), weights = MatrixXd::Random(7, 5);
  const auto vectors = vectors_of(columns, 9);
  vectors->combine(weights);
  MatrixXd expected = columns;
  expected.leftCols(5) = columns.leftCols(7) * weights;
  expect_near(vectors->columns(0, 9), expected);
}

TEST(LongVectors, MayBeShort) {
  for (Index rows = 1; rows < 10; ++rows) {
    const MatrixXd columns = MatrixXd::Random(rows, 3), mass_weighted = MatrixXd::Random(rows, 2);
    const auto vectors = vectors_of(columns, 3);
    MatrixXd block = mass_weighted;
    vectors->project_out(0, 3, mass_weighted, block);
    expect_near(block, mass_weighted - columns * (columns.transpose() * mass_weighted));
  }
}

TEST(LongVectors, StayWhereTheirRoomChanges) {
  const MatrixXd columns = MatrixXd::Random(1001, 6);
  const auto vectors = vectors_of(columns, 6);
  vectors->reserve(50);
  EXPECT_EQ(vectors->capacity(), 50);
  EXPECT_EQ(vectors->columns(0, 6), columns);
  vectors->reserve(4);
  EXPECT_EQ(vectors->capacity(), 4);
  EXPECT_EQ(vectors->columns(0, 4), columns.leftCols(4));
}

TEST(LongVectors, RefuseMoreRoomThanThereIs) {
  const auto vectors = make_long_vectors(1000000);
  EXPECT_THROW(vectors->reserve(Index{1} << 30), std::bad_alloc);
}

}  // namespace
}  // namespace kalfem
