// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/filter_setup.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::optional<MeasurementModel> monitored_map(const AugmentedModel& augmented_model, const OutputMap& monitored) {
  if (monitored.size() == 0) return std::nullopt;
  return MeasurementModel(augmented_model,
                          [&](const AugmentedModel& each) { return each.augmented_model_form().outputs(monitored); });
}

}  // namespace

FilterSetup::FilterSetup(std::shared_ptr<const AugmentedModel> of, const MatrixXd& measurement_noise,
                         const EstimationOptions& options)
    : augmented_model(std::move(of)),
      transition(*augmented_model),
      measurement(*augmented_model, sensor_outputs),
      monitored(monitored_map(*augmented_model, options.monitored)),
      filter(make_filter(options.filter,
                         {.process = transition,
                          .process_noise = augmented_model->process_noise(),
                          .measurement = measurement,
                          .measurement_noise = measurement_noise,
                          .monitored = monitored ? &*monitored : nullptr},
                         options.unscented, options.threads)) {
  filter->treat_outliers(options.outliers);
}

std::optional<Index> FilterSetup::failed_connector() const {
  if (const auto failed = transition.failed_connector()) return failed;
  if (const auto failed = measurement.failed_connector()) return failed;
  return monitored ? monitored->failed_connector() : std::nullopt;
}

void set_inputs_to(Index k, const FilterInput& input, Index instants, ProcessModel& transition) {
  const Index stride = input.input_stride(instants);
  if (stride > 1)
    transition.set_inputs(input.inputs.middleCols((k - 1) * stride, stride + 1));
  else
    transition.set_inputs(input.inputs.col(k - 1), input.inputs.col(k));
}

FilterOutcome predict_to(Index k, const FilterInput& input, FilterSetup& setup) {
  auto& [of, transition, measurement, monitored, filter] = setup;
  set_inputs_to(k, input, of->options().instants(), transition);
  if (transition.moving_gain() > 0) transition.set_mean(filter->mean());
  return filter->predict();
}

FilterOutcome update_at(Index k, const FilterInput& input, const std::vector<HeldOutSamples>& held_out,
                        FilterSetup& setup, VectorXd& y, Innovation& innovation) {
  auto& [of, transition, measurement, monitored, filter] = setup;
  measurement.set_inputs(input.inputs.col(k * input.input_stride(of->options().instants())));
  if (measurement.moving_gain() > 0) measurement.set_mean(filter->mean());
  input.sample(k, y);
  std::vector<Index> channels;
  for (const auto& [channel, begin, end] : held_out)
    if (begin <= k && k < end) channels.push_back(channel);
  return filter->update(y, innovation, channels);
}

LinearEstimate linear_estimate(const AugmentedModel& augmented_model, const std::vector<Index>& places,
                               const EstimatedSeries& estimated, std::optional<Index> k) {
  const auto count = static_cast<Index>(places.size());
  LinearEstimate estimate{VectorXd(count), VectorXd(count)};
  for (Index i = 0; i < count; ++i) {
    const Index at = places[static_cast<std::size_t>(i)];
    const auto& unknown = augmented_model.options().unknowns[static_cast<std::size_t>(at)];
    estimate.values[i] = k ? estimated.mean(at, *k) : unknown.initial;
    estimate.deviations[i] = k ? estimated.deviation(at, *k) : unknown.deviation;
  }
  return estimate;
}

bool LinearEstimate::outdates(const LinearEstimate& there) const {
  for (Index i = 0; i < values.size(); ++i) {
    const double scale = std::max(std::abs(values[i]), deviations[i]);
    const bool moved = std::abs(values[i] - there.values[i]) > 0.1 * std::sqrt(deviations[i] * scale);
    const bool shrunk = there.deviations[i] > 0.01 * scale && deviations[i] < 0.5 * there.deviations[i];
    if (moved || shrunk) return true;
  }
  return false;
}

std::unique_ptr<FilterSetup> moved_to(const std::shared_ptr<const AugmentedModel>& model, const FilterSetup& before,
                                      const MatrixXd& measurement_noise, const EstimationOptions& options) {
  auto setup = std::make_unique<FilterSetup>(model, measurement_noise, options);
  // The coordinates depend on where the model is linearised; the estimate goes over through the physical ones.
  const auto& old = *before.augmented_model;
  setup->filter->reset({model->own(old.physical(before.filter->mean())),
                        model->own_covariance(old.physical_covariance(before.filter->covariance()))});
  return setup;
}

void widen(FilterSetup& setup, Index state, double variance) {
  Gaussian now{setup.filter->mean(), setup.filter->covariance()};
  now.covariance(state, state) += variance;
  setup.filter->reset(now);
}

std::unique_ptr<FilterSetup> relinearised(const AugmentedModel& first, const LinearEstimate& here,
                                          const FilterSetup& before, const MatrixXd& measurement_noise,
                                          const EstimationOptions& options) {
  return moved_to(std::make_shared<const AugmentedModel>(first.about(here.values, here.deviations)), before,
                  measurement_noise, options);
}

}  // namespace kalfem
