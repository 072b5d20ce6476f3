#include "kalfem/estimation/partially_linear/partially_linear_filter.hpp"

#include "kalfem/estimation/kernels/small_kernels.hpp"
#include "kalfem/estimation/kernels/thin_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

UnscentedOptions of_channels(UnscentedOptions options) {
  options.points = SigmaPoints::of_channels;
  return options;
}

FilterOutcome why_not(const ProjectedMap& watched) {
  return watched.covariance_usable() ? FilterOutcome::model_not_evaluable
                                     : FilterOutcome::covariance_not_positive_definite;
}

}  // namespace

PartiallyLinearFilter::PartiallyLinearFilter(const UnscentedOptions& options, const PartiallyLinearMap& transition,
                                             TileLayout layout, int threads)
    : layout_(std::move(layout)),
      propagator_(transition.linear, layout_),
      transposed_(transition.linear.transpose(), layout_),
      gain_(layout_.placed(transition.gain)),
      covariance_(threads),
      transition_(of_channels(options)),
      measurement_(of_channels(options)),
      observation_(of_channels(options)) {
  transition_.take(transition, false);
}

void PartiallyLinearFilter::reset(const Gaussian& estimate) {
  mean_ = layout_.placed(estimate.mean);
  covariance_.reset(estimate.covariance, layout_);
  pending_ = fresh_ = false;
}

/// Rows of a map that is new, or has changed, join those whose products every pass forms.
void PartiallyLinearFilter::watch(ProjectedMap& watched, const PartiallyLinearMap& map) {
  if (watched.is(map) && rows_ready_) {
    if (!fresh_) refresh();
    return;
  }
  if (!watched.is(map)) watched.take(map, &watched == &measurement_);
  if (&watched == &observation_) observed_ = layout_.placed(map.linear.transpose());
  rows_ = {};
  for (auto* each : {&transition_, &measurement_, &observation_})
    if (!each->empty()) each->add_to(rows_, layout_);
  rows_.find_followers(transposed_);
  for (auto* each : {&transition_, &measurement_, &observation_})
    if (!each->empty()) each->find_places(rows_);
  gain_of_followers_ = gain_.transpose() * rows_.followers();
  process_noise_source_ = nullptr;
  rows_ready_ = true;
  refresh();
}

/// Takes J J^T from P and forms the products of all projected covariance anew.
void PartiallyLinearFilter::refresh() {
  if (fresh_) mean_ = products_.rightCols(1);
  products_.resize(layout_.slots(), rows_.size() + 1);
  products_.rightCols(1) = mean_;
  gram_.setZero((rows_.size() + tile_size - 1) / tile_size * tile_size, rows_.size() + 1);
  covariance_.pass({.downdate = pending_ ? &downdate_ : nullptr, .watched = &rows_.dense()}, products_);
  complete_products();
  pending_ = false;
  fresh_ = true;
}

/// Products of the rows that pick a state, which are columns of P, and all rows of the products.
void PartiallyLinearFilter::complete_products() {
  const Index dense = rows_.dense().cols();
  const auto& single = rows_.single();
  for (std::size_t i = 0; i < single.size(); ++i)
    covariance_.column(single[i], &products_(0, dense + static_cast<Index>(i)));
  thin_inner(rows_.dense(), products_, gram_);
  for (std::size_t i = 0; i < single.size(); ++i) gram_.row(dense + static_cast<Index>(i)) = products_.row(single[i]);
}

/// Takes the columns of G that change with every step.
void PartiallyLinearFilter::move_gain(const PartiallyLinearMap& transition) {
  for (Index column = gain_.cols() - transition.moving_gain; column < gain_.cols(); ++column) {
    for (std::size_t i = 0; i < layout_.slot.size(); ++i)
      gain_(layout_.slot[i], column) = transition.gain(static_cast<Index>(i), column);
    gain_of_followers_.row(column).noalias() = gain_.col(column).transpose() * rows_.followers();
  }
}

FilterOutcome PartiallyLinearFilter::predict(PartiallyLinearMap& transition, const MatrixXd& process_noise) {
  watch(transition_, transition);
  move_gain(transition);
  read_process_noise(process_noise);
  if (!transition_.spread(transition, gram_)) return why_not(transition_);

  thin_product(products_, transition_.slopes(), force_);
  propagator_.apply(force_, response_);
  add_thin_product(gain_, transition_.half_covariance(), response_);
  follow();

  propagator_.apply_to_column(products_, rows_.size());
  auto mean = products_.col(rows_.size());
  for (Index i = 0; i < transition.offset.size(); ++i)
    mean[layout_.slot[static_cast<std::size_t>(i)]] += transition.offset[i];
  mean.noalias() += gain_.lazyProduct(transition_.channel_mean());

  covariance_.pass({.downdate = pending_ ? &downdate_ : nullptr,
                    .propagator = &propagator_,
                    .gain = &gain_,
                    .response = &response_,
                    .process_noise = &process_noise_,
                    .watched = &rows_.leaders()},
                   products_);
  pending_ = false;
  complete_products();
  return FilterOutcome::usable;
}

/// P+ H^T of the rows h that follow, from P g^T of those they follow from: W^T h^T is F^T (P H^T)^T g^T and the part of
/// the gain.
void PartiallyLinearFilter::follow() {
  const auto& followed = rows_.followed();
  const auto count = static_cast<Index>(followed.size());
  followed_.resize(products_.rows(), count);
  response_of_followers_.noalias() = transition_.half_covariance().lazyProduct(gain_of_followers_);
  for (Index i = 0; i < count; ++i) {
    const Index leader = followed[static_cast<std::size_t>(i)];
    followed_.col(i) = products_.col(leader);
    response_of_followers_.col(i).noalias() +=
        transition_.slopes().transpose().lazyProduct(gram_.row(leader).head(rows_.size()).transpose());
  }
  propagator_.apply(followed_, following_);
  following_ += noise_of_followers_;
  add_thin_product(response_, gain_of_followers_, following_);
  add_thin_product(gain_, response_of_followers_, following_);
  products_.middleCols(rows_.leaders().cols(), count) = following_;
}

FilterOutcome PartiallyLinearFilter::update(PartiallyLinearMap& measurement, const MatrixXd& noise, const VectorXd& y,
                                            Innovation& innovation) {
  watch(measurement_, measurement);
  if (pending_) refresh();
  if (!measurement_.spread(measurement, gram_)) return why_not(measurement_);
  measurement_.output_mean(measurement, gram_, output_mean_);
  innovation.value = y - output_mean_;
  innovation.covariance = noise;
  measurement_.add_output_covariance(measurement, gram_, innovation.covariance);
  if (!cholesky(innovation.covariance, 0.0, innovation_factor_)) return FilterOutcome::innovation_not_positive_definite;
  whitened_ = innovation.value;
  whiten(innovation_factor_, whitened_);

  // P_xy = (P H^T) B, J = P_xy L^-T: x + J (L^-1 nu), P - J J^T, and both under H.
  measurement_.output_cross(measurement, cross_);
  solve_on_the_right(innovation_factor_, cross_);
  thin_product(products_, cross_, downdate_);
  thin_product(gram_, cross_, rows_of_downdate_);
  rows_and_score_.resize(rows_.size() + 1, y.size());
  rows_and_score_.topRows(rows_.size()) = rows_of_downdate_.topRows(rows_.size());
  rows_and_score_.bottomRows(1) = -whitened_.transpose();
  subtract_thin_product_transposed(downdate_, rows_and_score_, products_);
  subtract_thin_product_transposed(rows_of_downdate_, rows_and_score_, gram_);
  pending_ = true;
  score(innovation, innovation_factor_, whitened_);
  return FilterOutcome::usable;
}

/// The rows of outputs that are only looked at are many: their products with P are not formed at every step, and of
/// their covariance only the diagonal, A P A^T + 2 T G^T with T = A P_xf + G (delta^T delta + Sigma) / 2.
FilterOutcome PartiallyLinearFilter::observe(PartiallyLinearMap& map, VectorXd& mean, VectorXd* deviation) {
  watch(observation_, map);
  if (!observation_.spread(map, gram_)) return why_not(observation_);
  mean = map.offset;
  mean.noalias() += observed_.transpose() * products_.col(rows_.size());
  mean.noalias() += map.gain.lazyProduct(observation_.channel_mean());
  if (!deviation) return FilterOutcome::usable;

  observed_products_.resize(observed_.rows(), observed_.cols());
  covariance_.pass({.downdate = pending_ ? &downdate_ : nullptr, .watched = &observed_}, observed_products_);
  pending_ = false;
  thin_product(products_, observation_.slopes(), force_);
  observed_force_.noalias() = observed_.transpose() * force_;
  observed_force_.noalias() += map.gain.lazyProduct(observation_.half_covariance());
  *deviation = (observed_.cwiseProduct(observed_products_).colwise().sum().transpose() +
                2.0 * observed_force_.cwiseProduct(map.gain).rowwise().sum())
                   .cwiseMax(0.0)
                   .cwiseSqrt();
  return FilterOutcome::usable;
}

const VectorXd& PartiallyLinearFilter::mean() const {
  state_mean_.resize(static_cast<Index>(layout_.slot.size()));
  const auto mean = fresh_ ? products_.col(rows_.size()) : mean_.col(0);
  for (Index i = 0; i < state_mean_.size(); ++i) state_mean_[i] = mean[layout_.slot[static_cast<std::size_t>(i)]];
  return state_mean_;
}

VectorXd PartiallyLinearFilter::standard_deviation() const {
  VectorXd deviation(static_cast<Index>(layout_.slot.size()));
  for (Index i = 0; i < deviation.size(); ++i) {
    const Index slot = layout_.slot[static_cast<std::size_t>(i)];
    const double variance = covariance_.variance(slot) - (pending_ ? downdate_.row(slot).squaredNorm() : 0.0);
    deviation[i] = std::sqrt(std::max(0.0, variance));
  }
  return deviation;
}

MatrixXd PartiallyLinearFilter::covariance() const {
  MatrixXd covariance = covariance_.matrix(layout_);
  if (!pending_) return covariance;
  const MatrixXd downdate = downdate_(layout_.slot, Eigen::all);
  return covariance - downdate * downdate.transpose();
}

void PartiallyLinearFilter::read_process_noise(const MatrixXd& process_noise) {
  if (process_noise_source_ == &process_noise && process_noise.diagonal() == process_noise_diagonal_) return;
  process_noise_source_ = &process_noise;
  process_noise_diagonal_ = process_noise.diagonal();
  process_noise_ = SymmetricTiles(process_noise, layout_);
  const MatrixXd rows = layout_.placed(process_noise), placed = layout_.placed(rows.transpose());
  noise_of_followers_ = placed * rows_.followers();
}

}  // namespace kalfem
