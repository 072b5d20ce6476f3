// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/distributed_vectors.hpp"

#include <algorithm>
#include <new>

#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

template <class Work>
void by_blocks(Index columns, const Work& work) {
  by_panels(columns, VectorsPart::widest, work);
}

}  // namespace

DistributedVectors::DistributedVectors(Service& service, Index rows)
    : service_(service), number_(service.new_object()), rows_(rows), own_(service.ranks(), rows) {
  service_.together({Task::make_vectors, number_, {static_cast<int>(rows)}}, [] {});
}

DistributedVectors::~DistributedVectors() {
  service_.together({Task::free_vectors, number_}, [] {});
}

Order DistributedVectors::order(VectorsJob job, Index first, Index second, Index third) const {
  return {Task::use_vectors,
          number_,
          {static_cast<int>(job), static_cast<int>(first), static_cast<int>(second), static_cast<int>(third)}};
}

void DistributedVectors::reserve(Index capacity) {
  bool found = false;
  service_.together(order(VectorsJob::reserve, capacity), [&] { found = own_.reserve(capacity); });
  if (!found) throw std::bad_alloc();
}

void DistributedVectors::put(Index place, const Columns& block) {
  by_blocks(block.cols(), [&](Index first, Index count) {
    service_.together(order(VectorsJob::put, place + first, count),
                      [&] { own_.put(place + first, block.middleCols(first, count)); });
  });
}

void DistributedVectors::get(Index place, Eigen::Ref<MatrixXd> block) const {
  by_blocks(block.cols(), [&](Index first, Index count) {
    service_.together(order(VectorsJob::get, place + first, count),
                      [&] { own_.get(place + first, block.middleCols(first, count)); });
  });
}

// From the last vector to the first: those that are here are given up there.
MatrixXd DistributedVectors::take() {
  MatrixXd all(rows_, capacity());
  while (const Index count = std::min(VectorsPart::widest, capacity())) {
    const Index rest = capacity() - count;
    get(rest, all.middleCols(rest, count));
    reserve(rest);
  }
  return all;
}

MatrixXd DistributedVectors::products(Index begin, Index end, const Columns& block) const {
  MatrixXd products(end - begin, block.cols());
  if (begin == end) return products;
  by_blocks(block.cols(), [&](Index first, Index count) {
    service_.together(order(VectorsJob::products, begin, end, count), [&] {
      products.middleCols(first, count) = own_.products(begin, end, block.middleCols(first, count));
    });
  });
  return products;
}

MatrixXd DistributedVectors::project_out(Index begin, Index end, const Columns& mass_weighted,
                                         Eigen::Ref<MatrixXd> block) const {
  MatrixXd coefficients(end - begin, block.cols());
  if (begin == end) return coefficients;
  by_blocks(block.cols(), [&](Index first, Index count) {
    service_.together(order(VectorsJob::project_out, begin, end, count), [&] {
      coefficients.middleCols(first, count) =
          own_.project_out(begin, end, mass_weighted.middleCols(first, count), block.middleCols(first, count));
    });
  });
  return coefficients;
}

MatrixXd DistributedVectors::combination(const Columns& weights) const {
  MatrixXd combined(rows_, weights.cols());
  by_blocks(weights.cols(), [&](Index first, Index count) {
    service_.together(order(VectorsJob::combination, weights.rows(), count),
                      [&] { own_.combination(weights.middleCols(first, count), combined.middleCols(first, count)); });
  });
  return combined;
}

void DistributedVectors::combine(const Columns& weights) {
  service_.together(order(VectorsJob::combine, weights.rows(), weights.cols()), [&] { own_.combine(weights); });
}

}  // namespace kalfem::distributed
