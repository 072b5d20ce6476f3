// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/fixed_lag.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/units.hpp"
#include "kalfem/estimation/smoother/smoothed_outputs.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double most_memory = 4e9;  ///< [byte]

Gaussian estimate_of(const FilterSetup& setup) { return {setup.filter->mean(), setup.filter->covariance()}; }

bool is_empty(const LinearisedMeasurement& measurement) { return measurement.output.size() == 0; }

/// x of one model in the coordinates of another: T of x' = T x.
MatrixXd between(const AugmentedModel& from, const AugmentedModel& to) {
  const Index n = from.layout().size();
  return to.own(from.physical(MatrixXd::Identity(n, n)));
}

}  // namespace

void check_lag(Index lag, Index states, const SourceLocation& place, IssueList& issues) {
  const double each = 8.0 * static_cast<double>(states * states), needed = each * static_cast<double>(lag);
  if (needed <= most_memory) return;
  issues.add(place,
             "lag: " + std::to_string(lag) + " samples of " + std::to_string(states) + " states need " +
                 shortest(std::ceil(1e-9 * needed)) + " GB",
             "each sample keeps the covariance of the filter",
             "give a lag of at most " + std::to_string(static_cast<long>(most_memory / each)) + " samples");
}

FixedLag::FixedLag(Index lag, Index states, EstimationOptions options)
    : lag_(lag), options_(std::move(options)), linearisation_(options_), moments_(argument_transform_of(options_)) {
  IssueList issues;
  check_lag(lag, states, {}, issues);
  issues.raise();
}

void FixedLag::use(const ModelPlace& place, const FilterSetup& setup) {
  if (lag_ == 0) return;
  if (!steps_.empty()) {
    MatrixXd& coordinates = steps_.back().coordinates;
    const MatrixXd moved = between(*model_->augmented_model, *setup.augmented_model);
    coordinates = coordinates.size() == 0 ? moved : MatrixXd(moved * coordinates);
  }
  model_ = std::make_shared<const Model>(
      Model{place, setup.augmented_model, std::make_shared<const TransposedMap>(setup.transition)});
}

void FixedLag::begin(const FilterSetup& setup, long sample, const VectorXd& inputs) {
  if (lag_ == 0) return;
  steps_.clear();
  add(setup, sample, inputs);
}

void FixedLag::before_prediction(const FilterSetup& setup) {
  if (lag_ > 0) before_ = estimate_of(setup);
}

void FixedLag::after_prediction(FilterSetup& setup, long sample, const VectorXd& inputs) {
  if (lag_ == 0) return;
  const bool follows = !steps_.empty();
  LinearisedStep& transition = add(setup, sample, inputs).transition;
  if (!follows) return;
  transition.map = model_->transition;
  if (!linearisation_.linearise_prediction(setup, before_, transition)) begin(setup, sample, inputs);
}

void FixedLag::after_update(FilterSetup& setup, const Innovation& innovation, long sample, const VectorXd& inputs) {
  if (lag_ == 0) return;
  const bool is_next = steps_.empty() || steps_.back().coordinates.size() > 0 || !is_empty(steps_.back().measurement);
  Step& step = is_next ? add(setup, sample, inputs) : steps_.back();
  step.estimate = estimate_of(setup);
  step.inputs = inputs;
  smoothed_.reset();
  if (!linearisation_.linearise_update(setup, before_, innovation, step.measurement)) begin(setup, sample, inputs);
}

/// The step behind the last one. The oldest that is no longer needed gives its memory.
FixedLag::Step& FixedLag::add(const FilterSetup& setup, long sample, const VectorXd& inputs) {
  Step step;
  while (!steps_.empty() && steps_.front().sample < sample - lag_) {
    step = std::move(steps_.front());
    steps_.pop_front();
  }
  step.sample = sample;
  step.model = model_;
  step.transition.map.reset();
  step.measurement = {};
  step.coordinates.resize(0, 0);
  step.estimate = estimate_of(setup);
  step.inputs = inputs;
  smoothed_.reset();
  return steps_.emplace_back(std::move(step));
}

const SmoothedSample* FixedLag::smoothed() {
  if (steps_.empty()) return nullptr;
  if (smoothed_) return &*smoothed_;
  const long wanted = std::max(steps_.front().sample, steps_.back().sample - lag_);
  Adjoint adjoint = Adjoint::zero(steps_.back().estimate.mean.size());
  auto step = steps_.crbegin();
  for (;; ++step) {
    if (step->coordinates.size() > 0) adjoint.transform(step->coordinates);
    if (step->sample <= wanted) break;
    adjoint.pass(step->measurement);
    if (step->transition.map) adjoint.pass(step->transition);
  }
  smoothed_ = sample_of(*step, adjoint);
  return &*smoothed_;
}

SmoothedSample FixedLag::sample_of(const Step& step, const Adjoint& adjoint) {
  const auto& layout = step.model->augmented_model->layout();
  const Index n = layout.size(), first = layout.unknown(), unknowns = layout.unknowns;
  const MatrixXd covariance =
      smoothed_covariance(MatrixXd::Identity(n, n).middleRows(first, unknowns), step.estimate, adjoint);
  SmoothedSample sample{.sample = step.sample,
                        .unknowns = smoothed_mean(step.estimate, adjoint).segment(first, unknowns),
                        .unknowns_deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt()};
  if (options_.monitored.size() == 0 || smooth_monitored(step, adjoint, sample)) return sample;
  sample.outputs.setConstant(options_.monitored.size(), std::numeric_limits<double>::quiet_NaN());
  sample.outputs_deviation = sample.outputs;
  return sample;
}

bool FixedLag::smooth_monitored(const Step& step, const Adjoint& adjoint, SmoothedSample& sample) {
  MeasurementModel monitored(*step.model->augmented_model, [&](const AugmentedModel& each) {
    return each.augmented_model_form().outputs(options_.monitored);
  });
  monitored.set_inputs(step.inputs);
  return smooth_outputs(monitored, step.estimate, adjoint, moments_, sample.outputs, &sample.outputs_deviation);
}

void FixedLag::transfer(auto& step, auto& archive) {
  archive(step.sample);
  archive(step.transition.gain_of_arguments);
  archive(step.measurement.output);
  archive(step.measurement.gain);
  archive(step.measurement.weighted);
  archive(step.measurement.innovation);
  archive(step.estimate.mean);
  archive(step.estimate.covariance);
  archive(step.coordinates);
  archive(step.inputs);
}

// Models are kept by their places, each once for all steps in succession that have it; the present one follows.
void FixedLag::keep(ArchiveWriter& archive) const {
  if (lag_ == 0) return;
  const Model* last = nullptr;
  const auto keep_model = [&](const Model* model) {
    archive(model != last);
    if (model == last) return;
    last = model;
    archive(model->place.physical);
    archive(model->place.relinearised);
    archive(model->place.about.values);
    archive(model->place.about.deviations);
  };
  archive.each(steps_, [&](const Step& step) {
    keep_model(step.model.get());
    archive(step.transition.map != nullptr);
    transfer(step, archive);
  });
  keep_model(model_.get());
}

void FixedLag::take_up(ArchiveReader& archive, const ModelAt& model_at) {
  if (lag_ == 0) return;
  const auto take_up_model = [&] {
    bool is_another = false;
    archive(is_another);
    if (!is_another) return;
    ModelPlace place;
    archive(place.physical);
    archive(place.relinearised);
    archive(place.about.values);
    archive(place.about.deviations);
    auto augmented_model = model_at(place);
    auto transition = std::make_shared<const TransposedMap>(ProcessModel(*augmented_model));
    model_ = std::make_shared<const Model>(Model{place, std::move(augmented_model), std::move(transition)});
  };
  smoothed_.reset();
  steps_.clear();
  archive.each(steps_, [&](Step& step) {
    take_up_model();
    step.model = model_;
    bool is_led_to = false;
    archive(is_led_to);
    if (is_led_to) step.transition.map = model_->transition;
    transfer(step, archive);
  });
  take_up_model();
}

}  // namespace kalfem
