#include "kalfem/estimation/watched_map.hpp"

#include "kalfem/estimation/channel_factor.hpp"
#include "kalfem/estimation/thin_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Slot of the state that a row picks, -1 where it is not one state.
Index picked_slot(const Eigen::Ref<const VectorXd>& row) {
  Index slot = 0;
  return row.size() > 0 && row.cwiseAbs().sum() == 1.0 && row.maxCoeff(&slot) == 1.0 ? slot : -1;
}

void copy_columns(const MatrixXd& from, const std::vector<Index>& places, MatrixXd& to) {
  to.resize(from.rows(), static_cast<Index>(places.size()));
  for (std::size_t j = 0; j < places.size(); ++j) to.col(static_cast<Index>(j)) = from.col(places[j]);
}

}  // namespace

void WatchedMap::take(const PartiallyLinearMap& map, bool outputs, const TileLayout& layout) {
  map_ = &map;
  revision_ = map.revision;
  outputs_ = outputs;
  const MatrixXd selection = layout.placed(map.selection.transpose());
  dense_channels_.clear();
  single_channels_.clear();
  for (Index channel = 0; channel < selection.cols(); ++channel)
    if (const Index slot = picked_slot(selection.col(channel)); slot >= 0)
      single_channels_.push_back({channel, slot});
    else
      dense_channels_.push_back(channel);
  dense_selection_ = selection(Eigen::all, dense_channels_);
  if (outputs) linear_ = layout.placed(map.linear.transpose());
}

void WatchedMap::add_to(WatchedRows& rows, const TileLayout& layout) {
  selection_number_ = rows.add(map_->selection, layout);
  if (outputs_) linear_number_ = rows.add(map_->linear, layout);
}

void WatchedMap::find_places(const WatchedRows& rows) {
  selection_places_ = rows.places(selection_number_);
  if (outputs_) linear_places_ = rows.places(linear_number_);
}

bool WatchedMap::spread(PartiallyLinearMap& map, const MatrixXd& mean, const MatrixXd& products) {
  const Index q = map.selection.rows(), p = map.gain.cols();
  copy_columns(products, selection_places_, channel_cross_);

  thin_inner(dense_selection_, channel_cross_, dense_covariance_);
  covariance_.resize(q, q);
  for (std::size_t i = 0; i < dense_channels_.size(); ++i)
    covariance_.row(dense_channels_[i]) = dense_covariance_.row(static_cast<Index>(i));
  for (const auto& [channel, slot] : single_channels_) covariance_.row(channel) = channel_cross_.row(slot);
  covariance_usable_ = channel_factor(covariance_, factor_);
  if (!covariance_usable_) return false;

  thin_inner(dense_selection_, mean, dense_centre_);
  centre_ = map.input_offset;
  for (std::size_t i = 0; i < dense_channels_.size(); ++i)
    centre_[dense_channels_[i]] += dense_centre_(static_cast<Index>(i), 0);
  for (const auto& [channel, slot] : single_channels_) centre_[channel] += mean(slot, 0);
  if (!transform_.apply(map, centre_, factor_)) return false;

  const MatrixXd& delta = transform_.delta();
  slopes_ = delta;
  solve_channels_transposed(factor_, slopes_);
  thin_product(channel_cross_, slopes_, force_);
  force_covariance_ = transform_.scatter();
  for (Index j = 0; j < p; ++j)
    for (Index i = 0; i < p; ++i)
      for (Index k = 0; k < q; ++k) force_covariance_(i, j) += delta(k, i) * delta(k, j);
  return true;
}

void WatchedMap::output_mean(const PartiallyLinearMap& map, const MatrixXd& mean, VectorXd& y) {
  thin_inner(linear_, mean, output_of_mean_);
  y = map.offset;
  y += output_of_mean_.col(0);
  y.noalias() += map.gain.lazyProduct(transform_.mean());
}

void WatchedMap::output_cross(const PartiallyLinearMap& map, const MatrixXd& products, MatrixXd& cross) {
  copy_columns(products, linear_places_, cross);
  add_thin_product_transposed(force_, map.gain, cross);
}

void WatchedMap::add_output_covariance(const PartiallyLinearMap& map, const MatrixXd& products, MatrixXd& covariance) {
  copy_columns(products, linear_places_, output_products_);
  thin_inner(linear_, output_products_, output_covariance_);
  covariance += output_covariance_;
  thin_inner(linear_, force_, output_force_);
  output_force_.noalias() += 0.5 * map.gain.lazyProduct(force_covariance_);
  const Index l = covariance.rows(), p = map.gain.cols();
  for (Index j = 0; j < l; ++j)
    for (Index i = 0; i < l; ++i)
      for (Index c = 0; c < p; ++c)
        covariance(i, j) += output_force_(i, c) * map.gain(j, c) + map.gain(i, c) * output_force_(j, c);
}

}  // namespace kalfem
