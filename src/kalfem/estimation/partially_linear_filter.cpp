#include "kalfem/estimation/partially_linear_filter.hpp"

#include "kalfem/estimation/small_kernels.hpp"
#include "kalfem/estimation/thin_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

UnscentedOptions of_channels(UnscentedOptions options) {
  options.points = SigmaPoints::of_channels;
  return options;
}

FilterOutcome why_not(const WatchedMap& watched) {
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
  transition_.take(transition, false, layout_);
}

void PartiallyLinearFilter::reset(const Gaussian& estimate) {
  mean_ = layout_.placed(estimate.mean);
  covariance_.reset(estimate.covariance, layout_);
  pending_ = fresh_ = false;
}

/// Rows of a map that is new, or has changed, join those whose products every pass forms.
void PartiallyLinearFilter::watch(WatchedMap& watched, const PartiallyLinearMap& map) {
  if (watched.is(map) && fresh_) return;
  if (!watched.is(map)) watched.take(map, &watched != &transition_, layout_);
  rows_ = {};
  for (auto* each : {&transition_, &measurement_, &observation_})
    if (!each->empty()) each->add_to(rows_, layout_);
  rows_.find_followers(transposed_);
  for (auto* each : {&transition_, &measurement_, &observation_})
    if (!each->empty()) each->find_places(rows_);
  process_noise_source_ = nullptr;
  products_.resize(layout_.slots(), rows_.size());
  apply_downdate();
  fresh_ = true;
}

/// Takes J J^T from P and forms the products of all watched rows anew.
void PartiallyLinearFilter::apply_downdate() {
  covariance_.pass({.downdate = pending_ ? &downdate_ : nullptr, .watched = &rows_.dense()}, products_);
  pending_ = false;
  read_picked();
}

/// Products of the rows that pick a state: columns of P.
void PartiallyLinearFilter::read_picked() {
  for (std::size_t i = 0; i < rows_.single().size(); ++i)
    covariance_.column(rows_.single()[i], &products_(0, rows_.dense().cols() + static_cast<Index>(i)));
}

/// P+ H^T of the rows that follow, from the products before the pass.
void PartiallyLinearFilter::follow() {
  const auto& followed = rows_.followed();
  followed_.resize(products_.rows(), static_cast<Index>(followed.size()));
  for (std::size_t i = 0; i < followed.size(); ++i) followed_.col(static_cast<Index>(i)) = products_.col(followed[i]);
  propagator_.apply(followed_, following_);
  thin_inner(gain_, rows_.followers(), gain_rows_);
  thin_inner(response_, rows_.followers(), response_rows_);
  add_thin_product(response_, gain_rows_, following_);
  add_thin_product(gain_, response_rows_, following_);
  products_.middleCols(rows_.leaders().cols(), following_.cols()) = following_ + noise_of_followers_;
}

FilterOutcome PartiallyLinearFilter::predict(PartiallyLinearMap& transition, const MatrixXd& process_noise) {
  watch(transition_, transition);
  read_process_noise(process_noise);
  if (!transition_.spread(transition, mean_, products_)) return why_not(transition_);

  propagator_.apply(mean_, moved_mean_);
  for (Index i = 0; i < transition.offset.size(); ++i)
    moved_mean_(layout_.slot[static_cast<std::size_t>(i)], 0) += transition.offset[i];
  moved_mean_.noalias() += gain_.lazyProduct(transition_.channel_mean());
  mean_.swap(moved_mean_);

  propagator_.apply(transition_.cross(), response_);
  half_covariance_ = 0.5 * transition_.channel_covariance();
  add_thin_product(gain_, half_covariance_, response_);
  follow();
  covariance_.pass({.downdate = pending_ ? &downdate_ : nullptr,
                    .propagator = &propagator_,
                    .gain = &gain_,
                    .response = &response_,
                    .process_noise = &process_noise_,
                    .watched = &rows_.leaders()},
                   products_);
  pending_ = false;
  read_picked();
  return FilterOutcome::usable;
}

FilterOutcome PartiallyLinearFilter::update(PartiallyLinearMap& measurement, const MatrixXd& noise, const VectorXd& y,
                                            Innovation& innovation) {
  watch(measurement_, measurement);
  if (!measurement_.spread(measurement, mean_, products_)) return why_not(measurement_);
  measurement_.output_mean(measurement, mean_, output_mean_);
  innovation.value = y - output_mean_;
  innovation.covariance = noise;
  measurement_.add_output_covariance(measurement, products_, innovation.covariance);
  if (!cholesky(innovation.covariance, 0.0, innovation_factor_)) return FilterOutcome::innovation_not_positive_definite;
  whitened_ = innovation.value;
  whiten(innovation_factor_, whitened_);

  if (pending_) apply_downdate();
  measurement_.output_cross(measurement, products_, downdate_);
  solve_on_the_right(innovation_factor_, downdate_);
  pending_ = true;
  mean_.noalias() += downdate_.lazyProduct(whitened_);
  correct_products();
  score(innovation, innovation_factor_, whitened_);
  return FilterOutcome::usable;
}

/// P H^T of the updated covariance, P H^T - J (H J)^T.
void PartiallyLinearFilter::correct_products() {
  thin_inner(rows_.dense(), downdate_, dense_rows_of_downdate_);
  const Index dense = dense_rows_of_downdate_.rows();
  rows_of_downdate_.resize(rows_.size(), downdate_.cols());
  rows_of_downdate_.topRows(dense) = dense_rows_of_downdate_;
  for (std::size_t i = 0; i < rows_.single().size(); ++i)
    rows_of_downdate_.row(dense + static_cast<Index>(i)) = downdate_.row(rows_.single()[i]);
  subtract_thin_product_transposed(downdate_, rows_of_downdate_, products_);
}

FilterOutcome PartiallyLinearFilter::observe(PartiallyLinearMap& map, VectorXd& mean, VectorXd& deviation) {
  watch(observation_, map);
  if (!observation_.spread(map, mean_, products_)) return why_not(observation_);
  observation_.output_mean(map, mean_, mean);
  output_covariance_.setZero(mean.size(), mean.size());
  observation_.add_output_covariance(map, products_, output_covariance_);
  deviation = output_covariance_.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

const VectorXd& PartiallyLinearFilter::mean() const {
  state_mean_.resize(static_cast<Index>(layout_.slot.size()));
  for (Index i = 0; i < state_mean_.size(); ++i) state_mean_[i] = mean_(layout_.slot[static_cast<std::size_t>(i)], 0);
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
