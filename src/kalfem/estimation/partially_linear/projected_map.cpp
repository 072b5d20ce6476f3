#include "kalfem/estimation/partially_linear/projected_map.hpp"

#include "kalfem/estimation/partially_linear/argument_factor.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void ProjectedMap::take(const PartiallyLinearMap& map, bool outputs) {
  map_ = &map;
  revision_ = map.revision;
  outputs_ = outputs;
  linear_only_ = map.moving_gain == 0 && map.gain.isZero(0.0);
}

void ProjectedMap::add_to(ProjectedCovariance& rows, const TileLayout& layout) {
  if (!linear_only_) selection_number_ = rows.add(map_->selection, layout);
  if (outputs_) linear_number_ = rows.add(map_->linear, layout);
}

void ProjectedMap::find_places(const ProjectedCovariance& rows) {
  if (!linear_only_) selection_ = rows.places(selection_number_);
  if (outputs_) linear_ = rows.places(linear_number_);
  watched_ = rows.size();
  const Index p = map_->gain.cols();
  slopes_.setZero(watched_, p);
  half_covariance_.setZero(p, p);
  channel_mean_.setZero(p);
}

bool ProjectedMap::spread(PartiallyLinearMap& map, const MatrixXd& gram) {
  if (linear_only_) return true;
  const auto q = static_cast<Index>(selection_.size()), p = map.gain.cols();
  const auto place = [&](Index channel) { return selection_[static_cast<std::size_t>(channel)]; };
  covariance_.resize(q, q);
  centre_.resize(q);
  for (Index j = 0; j < q; ++j) {
    for (Index i = j; i < q; ++i) covariance_(i, j) = gram(place(i), place(j));
    centre_[j] = gram(place(j), watched_) + map.input_offset[j];
  }
  covariance_usable_ = argument_factor(covariance_, factor_);
  if (!covariance_usable_ || !transform_.apply(map, centre_, factor_)) return false;

  channel_mean_ = transform_.mean();
  const MatrixXd& delta = transform_.delta();
  channel_slopes_ = delta;
  solve_channels_transposed(factor_, channel_slopes_);
  slopes_.setZero();
  half_covariance_ = 0.5 * transform_.scatter();
  for (Index j = 0; j < p; ++j) {
    for (Index k = 0; k < q; ++k) slopes_(place(k), j) += channel_slopes_(k, j);
    for (Index i = 0; i < p; ++i)
      for (Index k = 0; k < q; ++k) half_covariance_(i, j) += 0.5 * delta(k, i) * delta(k, j);
  }
  return true;
}

void ProjectedMap::output_mean(const PartiallyLinearMap& map, const MatrixXd& gram, VectorXd& y) const {
  y = map.offset;
  for (std::size_t i = 0; i < linear_.size(); ++i) y[static_cast<Index>(i)] += gram(linear_[i], watched_);
  if (!linear_only_) y.noalias() += map.gain.lazyProduct(channel_mean_);
}

/// A P A^T + T G^T + G T^T with T = A P_xf + G half_covariance.
void ProjectedMap::add_output_covariance(const PartiallyLinearMap& map, const MatrixXd& gram, MatrixXd& covariance) {
  const auto l = static_cast<Index>(linear_.size()), p = map.gain.cols();
  const auto place = [&](Index row) { return linear_[static_cast<std::size_t>(row)]; };
  if (linear_only_) {
    for (Index j = 0; j < l; ++j)
      for (Index i = 0; i < l; ++i) covariance(i, j) += gram(place(i), place(j));
    return;
  }
  output_force_.noalias() = map.gain.lazyProduct(half_covariance_);
  for (Index c = 0; c < p; ++c)
    for (Index k = 0; k < watched_; ++k)
      if (slopes_(k, c) != 0.0)
        for (Index i = 0; i < l; ++i) output_force_(i, c) += gram(place(i), k) * slopes_(k, c);
  for (Index j = 0; j < l; ++j)
    for (Index i = 0; i < l; ++i) {
      double sum = gram(place(i), place(j));
      for (Index c = 0; c < p; ++c) sum += output_force_(i, c) * map.gain(j, c) + map.gain(i, c) * output_force_(j, c);
      covariance(i, j) += sum;
    }
}

void ProjectedMap::output_cross(const PartiallyLinearMap& map, MatrixXd& cross) const {
  if (linear_only_)
    cross.setZero(watched_, map.gain.rows());
  else
    cross.noalias() = slopes_.lazyProduct(map.gain.transpose());
  for (std::size_t i = 0; i < linear_.size(); ++i) cross(linear_[i], static_cast<Index>(i)) += 1.0;
}

}  // namespace kalfem
