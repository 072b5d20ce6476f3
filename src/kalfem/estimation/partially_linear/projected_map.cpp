// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/projected_map.hpp"

#include <algorithm>

#include "kalfem/estimation/partially_linear/argument_factor.hpp"

namespace kalfem {

namespace {

constexpr Eigen::Index many_arguments = 100;  ///< from here on the cost of points along dependent ones counts

}  // namespace

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// With H among whose rows are those of N (and of A, for outputs) every moment that the transform of
// docs/theory/partially-linear-ukf.md needs is read off the small matrix H [P H^T, x]:
//   1. spread():  P_ww = N P N^T and mean(w) are entries of it; P_ww = L L^T, sigma points of w, delta and Sigma; then
//      P_xf = (P H^T) F with F = L^-T delta in the rows of N.
//   2. outputs:   mean(y), P_yy = A P A^T + A P_xf G^T + G P_xf^T A^T + G (delta^T delta + Sigma) G^T and
//      P_xy = P A^T + P_xf G^T = (P H^T) B, again from entries and F.

void ProjectedMap::add_to(ProjectedRows& rows, const TileLayout& layout, bool outputs) {
  outputs_ = outputs;
  linear_only_ = map_.moving_gain() == 0 && map_.gain().isZero(0.0);
  if (!linear_only_) selection_number_ = rows.add(map_.selection(), layout);
  if (outputs_) linear_number_ = rows.add(map_.linear(), layout);
}

void ProjectedMap::find_places(const ProjectedRows& rows) {
  if (!linear_only_) selection_ = rows.places(selection_number_);
  if (outputs_) linear_ = rows.places(linear_number_);
  rows_ = rows.size();
  const Index p = map_.gain().cols();
  slopes_.setZero(rows_, p);
  half_covariance_.setZero(p, p);
  nonlinear_mean_.setZero(p);
}

bool ProjectedMap::spread(const MatrixXd& gram) {
  if (linear_only_) return true;
  take_arguments(gram);
  if (!evaluate_arguments()) return false;
  set_covariances();
  return true;
}

bool ProjectedMap::spread_mean(const MatrixXd& gram) {
  if (linear_only_) return true;
  take_arguments(gram);
  return evaluate_arguments();
}

/// P_ww, lower triangle, and mean(w).
void ProjectedMap::take_arguments(const MatrixXd& gram) {
  const auto q = static_cast<Index>(selection_.size());
  const auto place = [&](Index argument) { return selection_[static_cast<std::size_t>(argument)]; };
  covariance_.resize(q, q);
  centre_.resize(q);
  for (Index j = 0; j < q; ++j) {
    for (Index i = j; i < q; ++i) covariance_(i, j) = gram(place(i), place(j));
    centre_[j] = gram(place(j), rows_) + map_.input_offset()[j];
  }
}

/// phi over sigma points, and its mean.
bool ProjectedMap::evaluate_arguments() {
  const auto q = static_cast<Index>(selection_.size());
  const auto dependent = q > many_arguments ? Dependent::left_out : Dependent::raised;
  covariance_usable_ = independent_argument_factor(covariance_, dependent, factor_, independent_);
  // Directions that have vanished since stay as points at the centre: their number changes nothing but array sizes.
  directions_ = std::max(directions_, static_cast<Index>(independent_.size()));
  if (!covariance_usable_ || !transform_.apply(map_, centre_, factor_.topLeftCorner(q, directions_), q)) return false;
  nonlinear_mean_ = transform_.mean();
  return true;
}

/// F and half the covariance of phi, from the points that were evaluated.
void ProjectedMap::set_covariances() {
  const auto q = static_cast<Index>(selection_.size()), p = map_.gain().cols();
  const auto place = [&](Index argument) { return selection_[static_cast<std::size_t>(argument)]; };
  const MatrixXd& delta = transform_.delta();
  solve_independent_transposed(factor_, independent_, delta, argument_slopes_transposed_);
  slopes_.setZero();
  half_covariance_ = 0.5 * transform_.scatter();
  for (Index j = 0; j < p; ++j) {
    for (Index k = 0; k < q; ++k) slopes_(place(k), j) += argument_slopes_transposed_(j, k);
    for (Index i = j; i < p; ++i) {
      double sum = half_covariance_(i, j);
      for (Index k = 0; k < delta.rows(); ++k) sum += 0.5 * delta(k, i) * delta(k, j);
      half_covariance_(i, j) = half_covariance_(j, i) = sum;
    }
  }
}

bool ProjectedMap::spread_about(const MatrixXd& gram, const MatrixXd& downdate, const VectorXd& whitened) {
  const auto q = static_cast<Index>(selection_.size()), p = map_.gain().cols();
  const auto place = [&](Index argument) { return selection_[static_cast<std::size_t>(argument)]; };
  take_arguments(gram);
  prior_covariance_ = covariance_;
  prior_centre_ = centre_;
  for (Index c = 0; c < downdate.cols(); ++c)
    for (Index j = 0; j < q; ++j) {
      for (Index i = j; i < q; ++i) covariance_(i, j) -= downdate(place(i), c) * downdate(place(j), c);
      centre_[j] += downdate(place(j), c) * whitened[c];
    }
  if (!evaluate_arguments()) return false;
  set_covariances();
  argument_slopes_ = argument_slopes_transposed_.topRows(p).transpose();
  prior_products_.noalias() = prior_covariance_.selfadjointView<Eigen::Lower>() * argument_slopes_;
  half_covariance_ = 0.5 * transform_.scatter();
  half_covariance_.noalias() += 0.5 * argument_slopes_.transpose().lazyProduct(prior_products_);
  for (Index j = 0; j < p; ++j) nonlinear_mean_[j] += argument_slopes_.col(j).dot(prior_centre_ - centre_);
  return true;
}

bool ProjectedMap::settled() {
  deviation_ = covariance_.diagonal().cwiseMax(0.0).cwiseSqrt();
  return moves_.settle(centre_, deviation_);
}

void ProjectedMap::select_channels(const std::vector<Index>& channels) {
  const auto l = static_cast<Index>(channels.size());
  places_.resize(channels.size());
  gain_.resize(l, map_.gain().cols());
  offset_.resize(l);
  for (Index i = 0; i < l; ++i) {
    const Index channel = channels[static_cast<std::size_t>(i)];
    places_[static_cast<std::size_t>(i)] = linear_[static_cast<std::size_t>(channel)];
    gain_.row(i) = map_.gain().row(channel);
    offset_[i] = map_.offset()[channel];
  }
}

void ProjectedMap::output_mean(const MatrixXd& gram, VectorXd& y) const {
  y = offset_;
  for (std::size_t i = 0; i < places_.size(); ++i) y[static_cast<Index>(i)] += gram(places_[i], rows_);
  if (!linear_only_) y.noalias() += gain_.lazyProduct(nonlinear_mean_);
}

/// A P A^T + T G^T + G T^T with T = A P_xf + G half_covariance.
void ProjectedMap::add_output_covariance(const MatrixXd& gram, MatrixXd& covariance) {
  const auto l = static_cast<Index>(places_.size()), p = gain_.cols();
  const auto place = [&](Index row) { return places_[static_cast<std::size_t>(row)]; };
  if (linear_only_) {
    for (Index j = 0; j < l; ++j)
      for (Index i = 0; i < l; ++i) covariance(i, j) += gram(place(i), place(j));
    return;
  }
  output_force_.noalias() = gain_.lazyProduct(half_covariance_);
  for (Index c = 0; c < p; ++c)
    for (Index k = 0; k < rows_; ++k)
      if (slopes_(k, c) != 0.0)
        for (Index i = 0; i < l; ++i) output_force_(i, c) += gram(place(i), k) * slopes_(k, c);
  for (Index j = 0; j < l; ++j)
    for (Index i = 0; i < l; ++i) {
      double sum = gram(place(i), place(j));
      for (Index c = 0; c < p; ++c) sum += output_force_(i, c) * gain_(j, c) + gain_(i, c) * output_force_(j, c);
      covariance(i, j) += sum;
    }
}

void ProjectedMap::output_cross(MatrixXd& cross) const {
  if (linear_only_)
    cross.setZero(rows_, gain_.rows());
  else
    cross.noalias() = slopes_.lazyProduct(gain_.transpose());
  for (std::size_t i = 0; i < places_.size(); ++i) cross(places_[i], static_cast<Index>(i)) += 1.0;
}

}  // namespace kalfem
