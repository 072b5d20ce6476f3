// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/long_vectors.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/linalg/makers.hpp"
#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Nothing where they are to be in the memory of this process.
std::unique_ptr<LongVectors> vectors_elsewhere(Index rows) {
  const auto& maker = makers_in_use().long_vectors;
  return maker ? maker(rows) : nullptr;
}

}  // namespace

std::unique_ptr<LongVectors> make_long_vectors(Index rows) {
  if (auto vectors = vectors_elsewhere(rows)) return vectors;
  return std::make_unique<VectorsInMemory>(rows);
}

// From the last column to the first: those that have gone over are given up.
std::unique_ptr<LongVectors> make_long_vectors(MatrixXd columns) {
  auto vectors = vectors_elsewhere(columns.rows());
  if (!vectors) return std::make_unique<VectorsInMemory>(std::move(columns));
  vectors->reserve(columns.cols());
  while (const Index count = std::min<Index>(8, columns.cols())) {
    const Index rest = columns.cols() - count;
    vectors->put(rest, columns.rightCols(count));
    columns.conservativeResize(Eigen::NoChange, rest);
  }
  return vectors;
}

MatrixXd LongVectors::columns(Index begin, Index end) const {
  MatrixXd block(rows(), end - begin);
  get(begin, block);
  return block;
}

MatrixXd VectorsInMemory::take() { return std::exchange(vectors_, MatrixXd(vectors_.rows(), 0)); }

MatrixXd VectorsInMemory::products(Index begin, Index end, const Columns& block) const {
  return between(begin, end).transpose() * block;
}

MatrixXd VectorsInMemory::project_out(Index begin, Index end, const Columns& mass_weighted,
                                      Eigen::Ref<MatrixXd> block) const {
  MatrixXd coefficients = products(begin, end, mass_weighted);
  block.noalias() -= between(begin, end) * coefficients;
  return coefficients;
}

MatrixXd VectorsInMemory::combination(const Columns& weights) const { return between(0, weights.rows()) * weights; }

void VectorsInMemory::combine(const Columns& weights) { kalfem::combine(vectors_, weights); }

}  // namespace kalfem
