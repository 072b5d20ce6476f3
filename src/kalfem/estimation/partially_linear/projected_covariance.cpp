// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/projected_covariance.hpp"

#include <cassert>

#include "kalfem/estimation/kernels/thin_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The stored P is P + J J^T after an update: J is thin, and taking it off reads and writes all of P. So J waits for the
// next pass, which is due anyway. The products are small and are brought along at once.
ProjectedCovariance::ProjectedCovariance(ProjectedRows rows, TileLayout layout, int threads)
    : rows_(std::move(rows)),
      layout_(std::move(layout)),
      stored_(threads),
      products_(layout_.slots(), rows_.size() + 1),
      dense_(MatrixXd::Zero(whole_lanes(rows_.dense().cols()), layout_.slots())),
      gram_(MatrixXd::Zero(whole_lanes(rows_.size()), rows_.size() + 1)) {
  dense_.topRows(rows_.dense().cols()) = rows_.dense().transpose();
}

void ProjectedCovariance::reset(const Gaussian& estimate) {
  stored_.reset(estimate.covariance, layout_);
  downdate_waits_ = false;
  products_.rightCols(1) = layout_.placed(estimate.mean);
  pass({.projected = &rows_.dense()}, products_);
  complete_products();
}

void ProjectedCovariance::keep(ArchiveWriter& archive) const {
  stored_.transfer(archive);
  archive(downdate_waits_);
  archive(downdate_);
  archive(products_);
  archive(gram_);
}

void ProjectedCovariance::take_up(ArchiveReader& archive) {
  stored_.transfer(archive);
  archive(downdate_waits_);
  archive(downdate_);
  archive(products_);
  archive(gram_);
}

/// One pass over the stored P; a downdate that waits goes with it.
void ProjectedCovariance::pass(CovarianceStep step, MatrixXd& product) {
  if (downdate_waits_) step.downdate = &downdate_;
  stored_.pass(step, product);
  downdate_waits_ = false;
}

void ProjectedCovariance::propagate(CovarianceStep step, const MatrixXd& propagated, const MatrixXd& mean) {
  step.projected = &rows_.direct();
  pass(step, products_);
  products_.middleCols(rows_.direct().cols(), propagated.cols()) = propagated;
  products_.rightCols(1) = mean;
  complete_products();
}

void ProjectedCovariance::settle() {
  if (!downdate_waits_) return;
  pass({.projected = &rows_.dense()}, products_);
  complete_products();
}

/// Products of the rows that pick a state, which are columns of P, and all rows of the products.
void ProjectedCovariance::complete_products() {
  const Index dense = rows_.dense().cols();
  const auto& picked = rows_.picked();
  for (std::size_t i = 0; i < picked.size(); ++i)
    stored_.column(picked[i], &products_(0, dense + static_cast<Index>(i)));
  thin_inner(dense_, products_, gram_);
  for (std::size_t i = 0; i < picked.size(); ++i) gram_.row(dense + static_cast<Index>(i)) = products_.row(picked[i]);
}

/// [P H^T, x] <- [P H^T, x] - J [H J; -v^T]^T, and the same under H.
void ProjectedCovariance::condition(const MatrixXd& combination, const VectorXd& whitened) {
  assert(!downdate_waits_);
  thin_product(products_, combination, downdate_);
  thin_product(gram_, combination, rows_of_downdate_);
  rows_and_score_.resize(rows_.size() + 1, whitened.size());
  rows_and_score_.topRows(rows_.size()) = rows_of_downdate_.topRows(rows_.size());
  rows_and_score_.bottomRows(1) = -whitened.transpose();
  subtract_thin_product_transposed(downdate_, rows_and_score_, products_);
  subtract_thin_product_transposed(rows_of_downdate_, rows_and_score_, gram_);
  downdate_waits_ = true;
}

void ProjectedCovariance::multiply(const MatrixXd& columns, MatrixXd& product) {
  product.resize(columns.rows(), columns.cols());
  pass({.projected = &columns}, product);
}

VectorXd ProjectedCovariance::variances() const {
  VectorXd variances(layout_.slots());
  for (Index first = 0; first < variances.size(); first += lane_count) {
    Lanes taken = {};
    for (Index c = 0; downdate_waits_ && c < downdate_.cols(); ++c) {
      const Lanes values = load(&downdate_(first, c)), squares = values * values;
      taken = taken + squares;
    }
    stored_.diagonal(first / tile_size, &variances[first]);
    store(&variances[first], load(&variances[first]) - taken);
  }
  return variances;
}

MatrixXd ProjectedCovariance::covariance() const {
  MatrixXd covariance = stored_.matrix(layout_);
  if (!downdate_waits_) return covariance;
  const MatrixXd downdate = downdate_(layout_.slot, Eigen::all);
  return covariance - downdate * downdate.transpose();
}

MatrixXd ProjectedCovariance::covariance_of(const std::vector<Index>& states) const {
  const auto count = static_cast<Index>(states.size());
  const auto slot = [&](Index i) {
    return layout_.slot[static_cast<std::size_t>(states[static_cast<std::size_t>(i)])];
  };
  MatrixXd covariance(count, count);
  for (Index j = 0; j < count; ++j)
    for (Index i = j; i < count; ++i) {
      covariance(i, j) = stored_.entry(slot(i), slot(j));
      if (downdate_waits_) covariance(i, j) -= downdate_.row(slot(i)).dot(downdate_.row(slot(j)));
      covariance(j, i) = covariance(i, j);
    }
  return covariance;
}

}  // namespace kalfem
