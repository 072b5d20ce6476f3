// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/smoother.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/adaptive_filter.hpp"
#include "kalfem/estimation/excess.hpp"
#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/estimation/history_keeper.hpp"
#include "kalfem/estimation/narrow_prior.hpp"
#include "kalfem/estimation/smoother/smoothed_outputs.hpp"
#include "kalfem/estimation/smoother/step_linearisation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index fewest_in_segment = 4;

/// A model about one point of linearisation with the constants that the smoother needs of it.
struct SmootherModel {
  explicit SmootherModel(std::shared_ptr<FilterSetup> of)
      : setup(std::move(of)), transition(std::make_shared<const TransposedMap>(setup->transition)) {}
  std::shared_ptr<FilterSetup> setup;
  std::shared_ptr<const TransposedMap> transition;
};

/// The filter after the update at a sample, and after the relinearisation there, if any.
struct Checkpoint {
  Index sample = 0;
  std::shared_ptr<const AugmentedModel> model;
  LinearEstimate linearised_about;
  Gaussian estimate;
};

/// What the adjoint needs of one sample.
struct SmootherStep {
  LinearisedStep transition;  ///< from the sample before
  LinearisedMeasurement measurement;
  std::shared_ptr<const SmootherModel> model;
  Gaussian estimate;     ///< after the update
  MatrixXd coordinates;  ///< x of the relinearised model = T x; empty where it was not relinearised
};

/// The filter's second way over the record.
class FilterReplay {
public:
  FilterReplay(const AugmentedModel& augmented_model, const FilterInput& input, const EstimationOptions& options,
               const EstimationResult& filtered)
      : augmented_model_(augmented_model),
        input_(input),
        options_(options),
        filtered_(filtered),
        linear_unknowns_(linear_unknowns(augmented_model.options())),
        linearisation_(options),
        noise_(augmented_model, input.noise, filtered.noise) {}

  /// The update at the first sample from the prior; nothing where it fails.
  std::optional<SmootherStep> begin() {
    const std::shared_ptr<const AugmentedModel> first(std::shared_ptr<void>(), &augmented_model_);
    replace_model(std::make_shared<FilterSetup>(first, input_.noise, options_));
    const bool narrow = options_.passes > 1 && !augmented_model_.options().keep_initial_state;
    model_->setup->filter->reset(narrow ? narrow_prior(augmented_model_, filtered_) : filtered_.prior);
    linearised_about_ = linear_estimate(augmented_model_, linear_unknowns_, filtered_.unknowns);
    SmootherStep step;
    if (!update(0, &step)) return std::nullopt;
    return step;
  }

  [[nodiscard]] Checkpoint checkpoint(Index sample) const {
    const auto& setup = *model_->setup;
    return {sample, setup.augmented_model, linearised_about_, {setup.filter->mean(), setup.filter->covariance()}};
  }

  void restart(const Checkpoint& from) {
    if (!model_ || model_->setup->augmented_model != from.model)
      replace_model(std::make_shared<FilterSetup>(from.model, input_.noise, options_));
    model_->setup->filter->reset(from.estimate);
    linearised_about_ = from.linearised_about;
  }

  /// To sample k, with its linearisations where `step` is given. False where the filter cannot go on.
  bool advance(Index k, SmootherStep* step) {
    auto& setup = *model_->setup;
    Gaussian before;
    if (step) before = {setup.filter->mean(), setup.filter->covariance()};
    noise_.before_prediction(k, setup);
    if (predict_to(k, input_, setup) != FilterOutcome::usable) return false;
    if (step) {
      step->transition.map = model_->transition;
      if (!linearisation_.linearise_prediction(setup, before, step->transition)) return false;
    }
    return update(k, step);
  }

private:
  void replace_model(std::shared_ptr<FilterSetup> setup) {
    model_ = std::make_shared<SmootherModel>(std::move(setup));
    noise_.forget_setup();
  }

  bool update(Index k, SmootherStep* step) {
    auto& setup = *model_->setup;
    Gaussian predicted;
    if (step) predicted = {setup.filter->mean(), setup.filter->covariance()};
    innovation_.channels.clear();
    noise_.before_update(k, setup);
    if (update_at(k, input_, options_.held_out, setup, measured_, innovation_) != FilterOutcome::usable) return false;
    if (step) {
      step->model = model_;
      step->estimate = {setup.filter->mean(), setup.filter->covariance()};
      if (!linearisation_.linearise_update(setup, predicted, innovation_, step->measurement)) return false;
    }
    return relinearise(k, step);
  }

  /// As the filter did there.
  bool relinearise(Index k, SmootherStep* step) {
    if (linear_unknowns_.empty() || k + 1 == input_.measured.samples()) return true;
    auto now = linear_estimate(augmented_model_, linear_unknowns_, filtered_.unknowns, k);
    if (!now.outdates(linearised_about_)) return true;
    const auto before = model_;
    std::shared_ptr<FilterSetup> setup = relinearised(augmented_model_, now, *before->setup, input_.noise, options_);
    replace_model(std::move(setup));
    linearised_about_ = std::move(now);
    if (!step) return true;
    const Index n = step->estimate.mean.size();
    step->coordinates =
        model_->setup->augmented_model->own(before->setup->augmented_model->physical(MatrixXd::Identity(n, n)));
    return true;
  }

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  const EstimationOptions& options_;
  const EstimationResult& filtered_;
  std::vector<Index> linear_unknowns_;
  StepLinearisation linearisation_;
  NoiseReplay noise_;
  std::shared_ptr<SmootherModel> model_;
  LinearEstimate linearised_about_;
  Innovation innovation_;
  VectorXd measured_;
};

/// Takes smoothed estimates of one sample after the other and stores what is asked for.
class SmoothedSeries {
public:
  SmoothedSeries(const AugmentedModel& augmented_model, const FilterInput& input, const EstimationOptions& options)
      : augmented_model_(augmented_model),
        input_(input),
        options_(options),
        constants_(constant_states(augmented_model)),
        moments_(argument_transform_of(options)) {
    const auto series = [&](Index rows) {
      const MatrixXd empty = MatrixXd::Constant(rows, input.measured.samples(), std::nan(""));
      return EstimatedSeries{empty, empty};
    };
    record_ = {series(augmented_model.layout().size()),
               series(augmented_model.layout().unknowns),
               series(options.monitored.size()),
               {}};
    if (options.excess.size() > 0) record_.monitored_excess = record_.monitored.deviation;
  }

  bool store(Index k, const SmootherStep& step, const Adjoint& adjoint) {
    record_.state.mean.col(k) = step.model->setup->augmented_model->physical(smoothed_mean(step.estimate, adjoint));
    store_deviations(k, step, adjoint);
    store_unknowns(k);
    return options_.monitored.size() == 0 || store_monitored(k, step, adjoint);
  }

  /// Deviations of monitored quantities stand from one computed sample to the next, as the filter's do.
  SmoothedRecord finish() {
    for (MatrixXd* deviation : {&record_.monitored.deviation, &record_.monitored_excess})
      for (Index k = 0; k < deviation->cols(); ++k)
        deviation->col(k) = deviation->col(k - k % options_.deviation_stride).eval();
    return std::move(record_);
  }

private:
  void store_deviations(Index k, const SmootherStep& step, const Adjoint& adjoint) {
    const auto& layout = augmented_model_.layout();
    const Index n = layout.size();
    const Index first = options_.state_deviations ? 0 : layout.linear;
    const Index count = options_.state_deviations ? n : layout.connector_states + layout.unknowns;
    if (count == 0) return;
    MatrixXd covariance =
        smoothed_covariance(MatrixXd::Identity(n, n).middleRows(first, count), step.estimate, adjoint);
    if (options_.state_deviations) covariance = step.model->setup->augmented_model->physical_covariance(covariance);
    record_.state.deviation.col(k).segment(first, count) = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }

  void store_unknowns(Index k) {
    const auto& layout = augmented_model_.layout();
    for (Index i = 0; i < layout.unknowns; ++i) {
      const auto& transform = augmented_model_.options().unknowns[static_cast<std::size_t>(i)].transform;
      const double state = record_.state.mean(layout.unknown() + i, k);
      record_.unknowns.mean(i, k) = transform.to_parameter(state);
      record_.unknowns.deviation(i, k) = transform.slope(state) * record_.state.deviation(layout.unknown() + i, k);
    }
  }

  bool store_monitored(Index k, const SmootherStep& step, const Adjoint& adjoint) {
    auto& map = *step.model->setup->monitored;
    map.set_inputs(input_.inputs.col(k * input_.input_stride(augmented_model_.options().instants())));
    const bool anew = k % options_.deviation_stride == 0;
    if (!smooth_outputs(map, step.estimate, adjoint, moments_, outputs_, anew ? &deviations_ : nullptr)) return false;
    record_.monitored.mean.col(k) = outputs_;
    if (!anew) return true;
    record_.monitored.deviation.col(k) = deviations_;
    if (options_.excess.size() > 0) store_excess(k, step, adjoint);
    return true;
  }

  /// With P_y,theta = A P_x,theta + G slopes^T N P_x,theta of the smoothed estimate.
  void store_excess(Index k, const SmootherStep& step, const Adjoint& adjoint) {
    const auto& map = *step.model->setup->monitored;
    const MatrixXd& P = step.estimate.covariance;
    const MatrixXd before = P(Eigen::all, constants_);
    const MatrixXd with = before - P * (adjoint.matrix * before);
    const MatrixXd cross =
        map.linear() * with + map.gain() * (moments_.slopes().transpose() * (map.selection() * with));
    record_.monitored_excess.col(k) = deviation_of_excess(cross, with(constants_, Eigen::all), options_.excess);
  }

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  const EstimationOptions& options_;
  std::vector<Index> constants_;
  ArgumentMoments moments_;
  VectorXd outputs_, deviations_;
  SmoothedRecord record_;
};

/// From the last sample to the first, segment by segment.
class BackwardPass {
public:
  BackwardPass(FilterReplay& replay, SmoothedSeries& series, Index states, Index segment)
      : replay_(replay), series_(series), adjoint_(Adjoint::zero(states)), segment_(segment) {}

  /// Smooths the samples behind the checkpoint up to `last`. Where these are more than one segment, sets further
  /// checkpoints and treats the parts between them alike.
  bool smooth_behind(const Checkpoint& from, Index last) {
    const Index count = last - from.sample;
    if (count <= segment_) return smooth_segment(from, last);
    const Index spacing = (count + segment_ - 1) / segment_;
    std::vector<Checkpoint> checkpoints{from};
    replay_.restart(from);
    for (Index k = from.sample + 1; k <= last - spacing; ++k) {
      if (!replay_.advance(k, nullptr)) return false;
      if ((k - from.sample) % spacing == 0) checkpoints.push_back(replay_.checkpoint(k));
    }
    for (; !checkpoints.empty(); checkpoints.pop_back()) {
      if (!smooth_behind(checkpoints.back(), last)) return false;
      last = checkpoints.back().sample;
    }
    return true;
  }

  bool smooth(Index k, const SmootherStep& step) {
    stop_if_asked();
    if (step.coordinates.size() > 0) adjoint_.transform(step.coordinates);
    if (!series_.store(k, step, adjoint_)) return false;
    adjoint_.pass(step.measurement);
    if (step.transition.map) adjoint_.pass(step.transition);
    return true;
  }

private:
  bool smooth_segment(const Checkpoint& from, Index last) {
    std::vector<SmootherStep> steps(static_cast<std::size_t>(last - from.sample));
    replay_.restart(from);
    Index k = from.sample;
    for (auto& step : steps)
      if (!replay_.advance(++k, &step)) return false;
    for (; !steps.empty(); steps.pop_back(), --k)
      if (!smooth(k, steps.back())) return false;
    return true;
  }

  FilterReplay& replay_;
  SmoothedSeries& series_;
  Adjoint adjoint_;
  Index segment_;
};

/// The square root of the record's length needs the fewest estimates at once with one more run; memory limits it.
Index segment_length(Index samples, Index states, const SmootherOptions& options) {
  const double estimate = 2.0 * 8.0 * static_cast<double>(states * states);
  const double most = options.memory / (2.0 * estimate), wanted = std::ceil(std::sqrt(static_cast<double>(samples)));
  return std::max(fewest_in_segment, static_cast<Index>(std::min(most, wanted)));
}

}  // namespace

std::optional<SmoothedRecord> smooth(const AugmentedModel& augmented_model, const FilterInput& input,
                                     const EstimationOptions& options, const EstimationResult& filtered,
                                     const SmootherOptions& smoother) try {
  const Index samples = input.measured.samples(), states = augmented_model.layout().size();
  FilterReplay replay(augmented_model, input, options, filtered);
  SmoothedSeries series(augmented_model, input, options);
  const auto first = replay.begin();
  if (!first) return std::nullopt;
  BackwardPass backward(replay, series, states, segment_length(samples, states, smoother));
  if (!backward.smooth_behind(replay.checkpoint(0), samples - 1)) return std::nullopt;
  if (!backward.smooth(0, *first)) return std::nullopt;
  return series.finish();
} catch (const InvalidInput&) {  // a linear part that is impossible, which the filter did not meet
  return std::nullopt;
}

}  // namespace kalfem
