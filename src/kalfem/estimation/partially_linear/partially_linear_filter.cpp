// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/partially_linear_filter.hpp"

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/estimation/kernels/small_kernels.hpp"
#include "kalfem/estimation/kernels/thin_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A step, with the formulas of docs/theory/partially-linear-ukf.md ("Sigma points of w alone", "One pass over the
// covariance"). H are the rows of N and of the measured outputs; ProjectedCovariance keeps [P H^T, x].
//   predict:  1. sigma points of w from H P H^T give mean(phi), F, delta and Sigma.
//             2. W = A P_xf + U (delta^T delta + Sigma) / 2 with P_xf = (P H^T) F.
//             3. x+ = A x + U mean(phi) + b, and P+ h^T of the propagated rows from P g^T.
//             4. one pass over P: P+ = A (P - J J^T) A^T + W U^T + U W^T + Q, and P+ h^T of the direct rows.
//   update:   1. sigma points of w_y give mean(y), P_yy + R = L L^T and P_xy = (P H^T) B.
//             2. J = P_xy L^-T; x + J L^-1 (y - mean(y)) and P - J J^T, which waits for the next pass.

namespace {

UnscentedOptions of_arguments(UnscentedOptions options) {
  options.points = SigmaPoints::of_arguments;
  return options;
}

FilterOutcome why_not(const ProjectedMap& map) {
  return map.covariance_usable() ? FilterOutcome::model_not_evaluable : FilterOutcome::covariance_not_positive_definite;
}

}  // namespace

PartiallyLinearFilter::PartiallyLinearFilter(const FilterModel& model, const UnscentedOptions& options,
                                             TileLayout layout, int threads)
    : Filter(model),
      layout_(std::move(layout)),
      propagator_(model.process.linear(), layout_),
      gain_(layout_.placed(model.process.gain())),
      process_noise_(model.process_noise, layout_),
      process_map_(model.process, of_arguments(options)),
      measurement_map_(model.measurement, of_arguments(options)),
      monitored_map_(model.monitored ? std::make_optional<ProjectedMap>(*model.monitored, of_arguments(options))
                                     : std::nullopt),
      estimate_(rows_of_maps(), layout_, threads) {
  const auto& propagated = estimate_.rows().propagated();
  gain_of_propagated_ = gain_.transpose() * propagated;
  set_noise_of_propagated();
  if (model.monitored) monitored_ = layout_.placed(model.monitored->linear().transpose());
}

void PartiallyLinearFilter::set_process_noise(const MatrixXd& noise) {
  Filter::set_process_noise(noise);
  process_noise_ = SymmetricTiles(noise, layout_);
  set_noise_of_propagated();
}

void PartiallyLinearFilter::set_noise_of_propagated() {
  const MatrixXd rows = layout_.placed(process_noise()), placed = layout_.placed(rows.transpose());
  noise_of_propagated_ = placed * estimate_.rows().propagated();
}

/// The rows whose products with P the maps need.
ProjectedRows PartiallyLinearFilter::rows_of_maps() {
  ProjectedRows rows;
  process_map_.add_to(rows, layout_, false);
  measurement_map_.add_to(rows, layout_, true);
  if (monitored_map_) monitored_map_->add_to(rows, layout_, false);
  rows.find_propagated(TiledPropagator(process().linear().transpose(), layout_));
  process_map_.find_places(rows);
  measurement_map_.find_places(rows);
  if (monitored_map_) monitored_map_->find_places(rows);
  return rows;
}

void PartiallyLinearFilter::reset(const Gaussian& estimate) { estimate_.reset(estimate); }

FilterOutcome PartiallyLinearFilter::predict() {
  if (!process_map_.spread(estimate_.gram())) return why_not(process_map_);
  move_gain();
  thin_product(estimate_.products(), process_map_.slopes(), force_);
  propagator_.apply(force_, response_);
  add_thin_product(gain_, process_map_.half_covariance(), response_);
  propagate_rows();
  propagate_mean();
  estimate_.propagate(
      {.propagator = &propagator_, .gain = &gain_, .response = &response_, .process_noise = &process_noise_},
      propagated_products_, predicted_mean_);
  return FilterOutcome::usable;
}

/// Takes the columns of G that change with every step.
void PartiallyLinearFilter::move_gain() {
  const auto& map = process();
  for (Index column = gain_.cols() - map.moving_gain(); column < gain_.cols(); ++column) {
    for (std::size_t i = 0; i < layout_.slot.size(); ++i)
      gain_(layout_.slot[i], column) = map.gain()(static_cast<Index>(i), column);
    gain_of_propagated_.row(column).noalias() = gain_.col(column).transpose() * estimate_.rows().propagated();
  }
}

/// P+ h^T of the propagated rows from P g^T of their sources (ProjectedRows): W^T h^T is F^T (P H^T)^T g^T and the part
/// of the gain.
void PartiallyLinearFilter::propagate_rows() {
  const auto& rows = estimate_.rows();
  const auto& sources = rows.sources();
  const auto count = static_cast<Index>(sources.size());
  source_products_.resize(layout_.slots(), count);
  propagated_response_.noalias() = process_map_.half_covariance().lazyProduct(gain_of_propagated_);
  for (Index i = 0; i < count; ++i) {
    const Index source = sources[static_cast<std::size_t>(i)];
    source_products_.col(i) = estimate_.products().col(source);
    propagated_response_.col(i).noalias() +=
        process_map_.slopes().transpose().lazyProduct(estimate_.gram().row(source).head(rows.size()).transpose());
  }
  propagator_.apply(source_products_, propagated_products_);
  propagated_products_ += noise_of_propagated_;
  add_thin_product(response_, gain_of_propagated_, propagated_products_);
  add_thin_product(gain_, propagated_response_, propagated_products_);
}

/// x+ = A x + G mean(phi) + b.
void PartiallyLinearFilter::propagate_mean() {
  const auto& offset = process().offset();
  predicted_mean_ = estimate_.mean();
  propagator_.apply(predicted_mean_, predicted_mean_);
  for (Index i = 0; i < offset.size(); ++i) predicted_mean_(layout_.slot[static_cast<std::size_t>(i)], 0) += offset[i];
  predicted_mean_.col(0).noalias() += gain_.lazyProduct(process_map_.nonlinear_mean());
}

FilterOutcome PartiallyLinearFilter::expect(const VectorXd& y, const MatrixXd& noise, Innovation& innovation) {
  estimate_.settle();
  const auto& gram = estimate_.gram();
  if (!measurement_map_.spread(gram)) return why_not(measurement_map_);
  measurement_map_.select_channels(innovation.channels);
  measurement_map_.output_mean(gram, output_mean_);
  innovation.value = y - output_mean_;
  innovation.covariance = noise;
  measurement_map_.add_output_covariance(gram, innovation.covariance);
  return FilterOutcome::usable;
}

FilterOutcome PartiallyLinearFilter::correct(const MatrixXd& noise, Innovation& innovation) {
  if (!cholesky(innovation.covariance, 0.0, innovation_factor_)) return FilterOutcome::innovation_not_positive_definite;
  whitened_ = innovation.value;
  whiten(innovation_factor_, whitened_);

  measurement_map_.output_cross(combination_);
  solve_on_the_right(innovation_factor_, combination_);
  score(innovation, innovation_factor_, whitened_);
  if (update_iterations() > 1 && !measurement_map_.is_linear()) iterate(noise, innovation);
  estimate_.condition(combination_, whitened_);
  return FilterOutcome::usable;
}

/// The passes of IteratedUpdate. The posterior of the arguments and the measurement's moments follow from the small
/// gram matrix, so that a pass costs the same whatever the number of states. Each pass replaces `combination_`,
/// `whitened_` and the factor of the innovation's covariance; one that fails leaves those of the pass before.
void PartiallyLinearFilter::iterate(const MatrixXd& noise, Innovation& innovation) {
  const auto& gram = estimate_.gram();
  measurement_map_.begin_passes();
  for (int pass = 1; pass < update_iterations(); ++pass) {
    thin_product(gram, combination_, rows_of_downdate_);
    if (!measurement_map_.spread_about(gram, rows_of_downdate_, whitened_)) return;
    measurement_map_.output_mean(gram, output_mean_);
    next_value_ = measured_values() - output_mean_;
    next_covariance_ = noise;
    measurement_map_.add_output_covariance(gram, next_covariance_);
    if (!cholesky(next_covariance_, 0.0, next_factor_)) return;
    innovation.relinearised = true;
    innovation.about_posterior.value = whitened_ = next_value_;
    innovation.about_posterior.covariance = next_covariance_;
    innovation_factor_ = next_factor_;
    whiten(innovation_factor_, whitened_);
    measurement_map_.output_cross(combination_);
    solve_on_the_right(innovation_factor_, combination_);
    if (measurement_map_.settled()) return;
  }
}

/// The rows of monitored quantities are many: their products with P are not formed at every step, and of their
/// covariance only the diagonal, A P A^T + 2 T G^T with T = A P_xf + G (delta^T delta + Sigma) / 2.
FilterOutcome PartiallyLinearFilter::observe(VectorXd& mean, VectorXd* deviation) {
  const auto& map = monitored();
  auto& view = *monitored_map_;
  if (!(deviation ? view.spread(estimate_.gram()) : view.spread_mean(estimate_.gram()))) return why_not(view);
  mean = map.offset();
  mean.noalias() += monitored_.transpose() * estimate_.mean();
  mean.noalias() += map.gain().lazyProduct(view.nonlinear_mean());
  if (!deviation) return FilterOutcome::usable;

  estimate_.multiply(monitored_, monitored_products_);
  thin_product(estimate_.products(), view.slopes(), force_);
  monitored_force_.noalias() = monitored_.transpose() * force_;
  monitored_force_.noalias() += map.gain().lazyProduct(view.half_covariance());
  *deviation = (monitored_.cwiseProduct(monitored_products_).colwise().sum().transpose() +
                2.0 * monitored_force_.cwiseProduct(map.gain()).rowwise().sum())
                   .cwiseMax(0.0)
                   .cwiseSqrt();
  return FilterOutcome::usable;
}

/// A P_x,states + G P_f,states.
MatrixXd PartiallyLinearFilter::monitored_with(const std::vector<Index>& states) const {
  MatrixXd cross(monitored_.cols(), std::ssize(states));
  for (Index i = 0; i < cross.cols(); ++i) {
    const Index slot = layout_.slot[static_cast<std::size_t>(states[static_cast<std::size_t>(i)])];
    cross.col(i) = monitored_products_.row(slot).transpose() + monitored().gain() * force_.row(slot).transpose();
  }
  return cross;
}

const VectorXd& PartiallyLinearFilter::mean() const {
  const auto mean = estimate_.mean();
  mean_.resize(static_cast<Index>(layout_.slot.size()));
  for (Index i = 0; i < mean_.size(); ++i) mean_[i] = mean[layout_.slot[static_cast<std::size_t>(i)]];
  return mean_;
}

MatrixXd PartiallyLinearFilter::gain_of(const std::vector<Index>& states) const {
  const auto& downdate = estimate_.downdate();
  MatrixXd whitened(std::ssize(states), downdate.cols());
  for (Index i = 0; i < whitened.rows(); ++i)
    whitened.row(i) = downdate.row(layout_.slot[static_cast<std::size_t>(states[static_cast<std::size_t>(i)])]);
  return gain_from(whitened, innovation_factor_);
}

VectorXd PartiallyLinearFilter::standard_deviation() const {
  VectorXd deviation = estimate_.variances();
  KALFEM_INDEPENDENT
  for (Index i = 0; i < deviation.size(); ++i)  // std::sqrt is exact, Eigen's over registers is not
    deviation[i] = std::sqrt(deviation[i] > 0.0 ? deviation[i] : 0.0);
  return deviation(layout_.slot);
}

}  // namespace kalfem
