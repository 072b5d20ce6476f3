// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/estimate.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/estimation/adaptive_filter.hpp"
#include "kalfem/estimation/excess.hpp"
#include "kalfem/estimation/failure.hpp"
#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/estimation/history_keeper.hpp"
#include "kalfem/estimation/narrow_prior.hpp"
#include "kalfem/estimation/step_shift.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index progress_block = 512;  ///< samples between two reports of progress
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// The fewest variables that sigma points stand for: all states, or the arguments of a measurement.
Index sigma_point_variables(const AugmentedModel& augmented_model, FilterKind filter) {
  const auto& layout = augmented_model.layout();
  const bool of_arguments =
      filter == FilterKind::partially_linear || filter == FilterKind::partially_linear_square_root;
  return of_arguments ? MeasurementModel(augmented_model, sensor_outputs).selection().rows() : layout.size();
}

void check_sigma_points(const AugmentedModel& augmented_model, const EstimationOptions& options, IssueList& issues) {
  const auto& [alpha, beta, kappa, points, passes] = options.unscented;
  const auto n = static_cast<double>(sigma_point_variables(augmented_model, options.filter));
  const double spread = kappa ? n + *kappa : 1.0;
  if (alpha > 0.0 && spread > 0.0 && std::isfinite(alpha * alpha * spread) && std::isfinite(beta)) return;
  issues.add({},
             "the sigma points have alpha " + std::to_string(alpha) + ", beta " + std::to_string(beta) + ", kappa " +
                 (kappa ? std::to_string(*kappa) : "by default") + " with " + std::to_string(static_cast<Index>(n)) +
                 " variables",
             "alpha must be > 0 and kappa > minus the number of variables; all must be finite",
             "use alpha 1 and beta 2, and omit kappa");
}

void check(const AugmentedModel& augmented_model, const FilterInput& input, const EstimationOptions& options) {
  IssueList issues;
  const Index l = augmented_model.form().outputs().state.rows(), n_u = augmented_model.system().input_count();
  if (input.measured.values.rows() != l || input.noise.rows() != l || input.noise.cols() != l)
    issues.add({}, "the record or the noise does not have one channel per sensor", "");
  const Index samples = input.measured.samples(), fine = (samples - 1) * augmented_model.options().instants() + 1;
  if (input.inputs.rows() != 3 * n_u || (input.inputs.cols() != samples && input.inputs.cols() != fine))
    issues.add({}, "inputs and measurements have different numbers of samples", "");
  if (!input.inputs.allFinite()) issues.add({}, "an input is not finite", "the filter's model is driven by it");
  if (!input.noise.allFinite() || (input.noise.diagonal().array() < 0.0).any())
    issues.add({}, "a sensor's noise is negative or not finite", "it is a variance", "give every sensor its noise");
  const IssueList of_options = validate(augmented_model, options);
  for (const auto& [place, what, why, fix] : of_options.issues()) issues.add(place, what, why, fix);
  if (input.measured.samples() < 1) issues.add({}, "the record is empty", "");
  if (options.excess.size() > 0 && options.excess.rows() != std::ssize(constant_states(augmented_model)))
    issues.add({}, "the excess does not have one row per constant unknown", "");
  issues.raise();
}

/// One run of a filter over a record. At every sample: predict from the sample before, update by what was measured,
/// store, and relinearise the model where the unknowns of its linear part have moved. A run that cannot go on ends with
/// the outcome and the sample's time in the result.
class RecordRun {
public:
  RecordRun(const AugmentedModel& augmented_model, const FilterInput& input, const EstimationOptions& options)
      : augmented_model_(augmented_model),
        input_(input),
        options_(options),
        input_stride_(input.input_stride(augmented_model.options().instants())),
        setup_(std::make_unique<FilterSetup>(
            std::shared_ptr<const AugmentedModel>(std::shared_ptr<void>(), &augmented_model), input.noise, options)),
        linear_unknowns_(linear_unknowns(augmented_model.options())),
        constants_(constant_states(augmented_model)) {
    const auto& layout = augmented_model.layout();
    in_any_coordinates_.resize(static_cast<std::size_t>(layout.connector_states + layout.unknowns));
    std::iota(in_any_coordinates_.begin(), in_any_coordinates_.end(), layout.linear);
    allocate();
    linearised_about_ = linear_estimate(augmented_model_, linear_unknowns_, result_.unknowns);
    if (!options.step_shift || augmented_model.options().step_order != 4) return;
    shift_ = std::make_unique<StepShift>(setup_->augmented_model);
    result_.step_shift = MatrixXd::Constant(layout.unknowns, input.measured.samples(), not_a_number);
  }

  EstimationResult run(const Gaussian& prior) {
    setup_->filter->reset(prior);
    result_.prior = prior;
    if (options_.adaptive_noise.any())
      adaptation_ = std::make_unique<NoiseAdaptation>(augmented_model_, input_, options_, prior, *setup_);
    const Index samples = input_.measured.samples(), l = input_.measured.values.rows();
    if (options_.keep_unknowns) history_.emplace(augmented_model_, prior, samples, l);
    watch_ = {};
    for (Index k = 0; k < samples; ++k) {
      stop_if_asked();
      if (!step(k)) break;
      report_progress(k, samples);
    }
    return finish();
  }

private:
  /// False where the filter cannot go on from sample k.
  bool step(Index k) {
    auto& time = result_.time;
    const auto charged = [&](FilterOutcome outcome, double& to) {
      to += watch_.lap();
      return outcome;
    };
    renew_unknowns(k);
    const VectorXd before = shift_ && k > 0 ? setup_->filter->mean() : VectorXd();
    // Carry the estimate over the interval that ends at the sample; the prior already stands at the first one.
    FilterOutcome outcome = k == 0 ? FilterOutcome::usable : charged(predict_to(k, input_, *setup_), time.predict);
    if (adaptation_ && k > 0) adaptation_->predict_to(k);
    const VectorXd predicted = shift_ && outcome == FilterOutcome::usable ? setup_->filter->mean() : VectorXd();
    // Condition it on what the sensors show.
    if (outcome == FilterOutcome::usable)
      outcome = charged(update_at(k, input_, options_.held_out, *setup_, measured_, innovation_), time.update);
    if (outcome == FilterOutcome::usable && shift_) store_shift(k, before, predicted);
    // Store it, with the quantities that are monitored.
    if (outcome == FilterOutcome::usable) outcome = charged(store(k), time.output);
    if (outcome == FilterOutcome::usable && adaptation_) {
      adaptation_->learn(k, innovation_, *setup_);
      time.update += watch_.lap();
    }
    // The tangent along the linear part's unknowns holds near the point of linearisation only.
    if (outcome == FilterOutcome::usable && !linear_unknowns_.empty())
      outcome = charged(relinearise_where_it_moved(k), time.predict);
    if (outcome == FilterOutcome::usable) return true;
    stop(k, outcome);
    return false;
  }

  void store_shift(Index k, const VectorXd& before, const VectorXd& predicted) {
    if (k > 0) shift_->predict_to(k, input_, before);
    shift_->update_at(k, input_, predicted, *setup_->filter, innovation_);
    const auto& layout = augmented_model_.layout();
    for (Index i = 0; i < layout.unknowns; ++i) {
      const auto& transform = augmented_model_.options().unknowns[static_cast<std::size_t>(i)].transform;
      const double state = setup_->filter->mean()[layout.unknown() + i];
      result_.step_shift(i, k) = transform.slope(state) * shift_->value()[layout.unknown() + i];
    }
  }

  /// Widens the unknowns that may change over the interval that ends at sample k.
  void renew_unknowns(Index k) {
    for (const auto& [unknown, sample, deviation] : options_.renewals) {
      if (sample != k || k == 0) continue;
      const Index place = augmented_model_.layout().unknown() + unknown;
      widen(*setup_, place, deviation * deviation);
      if (adaptation_) adaptation_->widen(place, deviation * deviation);
    }
  }

  /// The result holds the samples before the one that failed, and this one too where only the linearisation about it
  /// was impossible.
  void stop(Index k, FilterOutcome outcome) {
    FailureTrace trace{.outcome = outcome, .sample = k, .computed = k, .connector = {}};
    if (outcome == FilterOutcome::linear_part_impossible) trace.computed = k + 1;
    leave_out(trace.computed);
    if (outcome == FilterOutcome::model_not_evaluable) trace.connector = setup_->failed_connector();
    result_.failure = explain_failure(trace, augmented_model_, input_, options_, result_);
  }

  void report_progress(Index k, Index samples) const {
    if (options_.progress && k % progress_block == 0)
      options_.progress("estimate", static_cast<double>(k) / static_cast<double>(samples));
  }

  EstimationResult finish() {
    result_.final_covariance = model().physical_covariance(setup_->filter->covariance());
    if (adaptation_) result_.noise = adaptation_->finish();
    if (history_) result_.unknowns_history = history_->take();
    if (result_.linearisations > 0) result_.augmented_model = setup_->augmented_model;
    return std::move(result_);
  }

  /// The augmented model as it is linearised now.
  [[nodiscard]] const AugmentedModel& model() const { return *setup_->augmented_model; }

  /// Every sample that is computed sets all of its column, but for what `state` is not asked for and channels that are
  /// missing.
  void allocate() {
    const Index samples = input_.measured.samples(), l = input_.measured.values.rows();
    const auto none = [&](Index rows) { return MatrixXd::Constant(rows, samples, not_a_number); };
    const auto unset = [&](Index rows) { return MatrixXd(rows, samples); };
    const Index n = augmented_model_.layout().size(), unknowns = augmented_model_.layout().unknowns;
    result_.state.mean = options_.state_means ? unset(n) : none(n);
    result_.state.deviation = options_.state_deviations ? unset(n) : none(n);
    result_.unknowns = {unset(unknowns), unset(unknowns)};
    result_.monitored = {unset(options_.monitored.size()), unset(options_.monitored.size())};
    if (options_.excess.size() > 0) result_.monitored_excess = none(options_.monitored.size());
    result_.innovation = result_.innovation_deviation = none(l);
    if (l <= most_covariances) result_.innovation_covariance = none(l * (l + 1) / 2);
    result_.nis = VectorXd::Constant(samples, not_a_number);
    result_.log_density = VectorXd::Zero(samples);
    result_.measured = Eigen::VectorXi::Zero(samples);
  }

  /// The samples from the first one that is not computed.
  void leave_out(Index first) {
    for (auto* series : {&result_.state, &result_.unknowns, &result_.monitored})
      for (auto* values : {&series->mean, &series->deviation})
        values->rightCols(values->cols() - first).setConstant(not_a_number);
  }

  FilterOutcome store(Index k) {
    store_innovation(k);
    store_state(k);
    if (history_) history_->keep(k, *setup_->filter, innovation_);
    const auto outcome = store_monitored(k);
    if (outcome == FilterOutcome::usable && options_.keep_gains) store_gain();
    return outcome;
  }

  void store_innovation(Index k) {
    for (SetAsideSample each : innovation_.set_aside) {
      each.sample = k;
      result_.set_aside.push_back(each);
    }
    const auto& channels = innovation_.channels;
    if (channels.empty()) return;
    result_.innovation(channels, k) = innovation_.value;
    result_.innovation_deviation(channels, k) = innovation_.covariance.diagonal().cwiseSqrt();
    if (result_.innovation_covariance.size() > 0)
      for (std::size_t i = 0; i < channels.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j)
          result_.innovation_covariance(channels[i] * (channels[i] + 1) / 2 + channels[j], k) =
              innovation_.covariance(static_cast<Index>(i), static_cast<Index>(j));
    result_.nis[k] = innovation_.nis;
    result_.log_density[k] = innovation_.log_likelihood;
    result_.log_likelihood += innovation_.log_likelihood;
    result_.measured[k] = static_cast<int>(channels.size());
  }

  void store_state(Index k) {
    const auto& layout = augmented_model_.layout();
    if (const VectorXd& mean = setup_->filter->mean(); options_.state_means || k + 1 == input_.measured.samples())
      result_.state.mean.col(k) = model().physical(mean);
    else
      result_.state.mean(in_any_coordinates_, k) = mean(in_any_coordinates_);
    store_deviations(k);
    for (Index i = 0; i < layout.unknowns; ++i) {
      const auto& transform = augmented_model_.options().unknowns[static_cast<std::size_t>(i)].transform;
      const double state = result_.state.mean(layout.unknown() + i, k);
      result_.unknowns.mean(i, k) = transform.to_parameter(state);
      result_.unknowns.deviation(i, k) = transform.slope(state) * result_.state.deviation(layout.unknown() + i, k);
    }
  }

  /// Of all states, or only of unknowns and internal states.
  void store_deviations(Index k) {
    auto deviations = result_.state.deviation.col(k);
    if (augmented_model_.options().coordinates == StateCoordinates::modal && options_.state_deviations) {
      deviations = model().physical_covariance(setup_->filter->covariance()).diagonal().cwiseMax(0.0).cwiseSqrt();
      return;
    }
    const VectorXd own = setup_->filter->standard_deviation();
    if (options_.state_deviations)
      deviations = own;
    else
      deviations(in_any_coordinates_) = own(in_any_coordinates_);
  }

  FilterOutcome store_monitored(Index k) {
    auto& [of, transition, measurement, monitored, filter] = *setup_;
    if (!monitored) return FilterOutcome::usable;
    monitored->set_inputs(input_.inputs.col(k * input_stride_));
    if (!linear_unknowns_.empty()) monitored->set_mean(filter->mean());
    const bool anew = k % options_.deviation_stride == 0;
    const auto outcome = filter->observe(output_mean_, anew ? &output_deviation_ : nullptr);
    if (outcome != FilterOutcome::usable) return outcome;
    if (anew && options_.excess.size() > 0)
      output_excess_ =
          deviation_of_excess(filter->monitored_with(constants_), filter->covariance_of(constants_), options_.excess);
    result_.monitored.mean.col(k) = output_mean_;
    result_.monitored.deviation.col(k) = output_deviation_;
    if (options_.excess.size() > 0) result_.monitored_excess.col(k) = output_excess_;
    return outcome;
  }

  /// In physical coordinates; 0 for a channel that is missing.
  void store_gain() {
    MatrixXd gain = MatrixXd::Zero(augmented_model_.layout().size(), input_.measured.values.rows());
    if (const auto& channels = innovation_.channels; !channels.empty())
      gain(Eigen::all, channels) = model().physical(setup_->filter->gain());
    result_.gains.push_back(std::move(gain));
  }

  FilterOutcome relinearise_where_it_moved(Index k) {
    auto now = linear_estimate(augmented_model_, linear_unknowns_, result_.unknowns, k);
    if (!now.outdates(linearised_about_)) return FilterOutcome::usable;
    try {
      setup_ = relinearised(augmented_model_, now, *setup_,
                            adaptation_ ? adaptation_->measurement_noise() : input_.noise, options_);
    } catch (const InvalidInput&) {
      return FilterOutcome::linear_part_impossible;
    }
    if (adaptation_) adaptation_->move_to(*setup_);
    if (shift_) shift_->move_to(setup_->augmented_model);
    linearised_about_ = std::move(now);
    ++result_.linearisations;
    return FilterOutcome::usable;
  }

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  const EstimationOptions& options_;
  Index input_stride_;  ///< columns of the inputs per sample
  std::unique_ptr<FilterSetup> setup_;
  std::unique_ptr<NoiseAdaptation> adaptation_;  ///< where the noise adapts
  std::unique_ptr<StepShift> shift_;             ///< where it is asked for
  std::vector<Index> linear_unknowns_;
  std::vector<Index> constants_;           ///< states of the unknowns that do not drift
  std::vector<Index> in_any_coordinates_;  ///< states that have the same meaning in all: internal ones and unknowns
  std::optional<HistoryKeeper> history_;   ///< where it is kept
  LinearEstimate linearised_about_;
  Stopwatch watch_;
  Innovation innovation_;
  VectorXd measured_, output_mean_, output_deviation_, output_excess_;
  EstimationResult result_;
};

/// The prior of the next run over the record: parameters and initial state of the last one, the first prior's
/// covariance; without an initial state narrow_prior().
Gaussian next_prior(const AugmentedModel& augmented_model, const EstimationResult& result) {
  const auto& layout = augmented_model.layout();
  const VectorXd last = result.state.mean.col(result.state.mean.cols() - 1);
  if (!augmented_model.options().keep_initial_state) return narrow_prior(augmented_model, result);
  return augmented_model.prior_about(last.segment(layout.unknown(), layout.unknowns),
                                     last.segment(layout.initial_state(), layout.linear),
                                     last.tail(layout.connector_states));
}

}  // namespace

Eigen::MatrixXi used_samples(const EstimationResult& result) {
  Eigen::MatrixXi used = result.innovation.array().isFinite().cast<int>();
  for (const auto& each : result.set_aside) used(each.channel, each.sample) = 0;
  return used;
}

void FilterInput::sample(Index k, VectorXd& y) const {
  y = measured.values.col(k);
  if (k >= measured.samples_used()) y.setConstant(not_a_number);
}

IssueList validate(const AugmentedModel& augmented_model, const EstimationOptions& options) {
  IssueList issues;
  check_sigma_points(augmented_model, options, issues);
  if (options.deviation_stride < 1) issues.add({}, "the stride of standard deviations is below 1", "");
  if (options.unscented.update_iterations < 1)
    issues.add({}, "the number of passes of an update is below 1", "", "use 1 for a plain update");
  if (options.adaptive_noise.any() && !(options.adaptive_noise.memory > 0.0))
    issues.add({}, "the memory of the adaptive noise is " + std::to_string(options.adaptive_noise.memory) + " s",
               "it must be > 0", "");
  if (options.adaptive_noise.any() && options.passes > 1)
    issues.add({}, "several passes are requested with adaptive noise",
               "each pass would find the noise of every instant again from its stated value", "set passes: 1");
  if (options.passes < 1) issues.add({}, "the number of passes is below 1", "");
  return issues;
}

EstimationResult estimate(const AugmentedModel& augmented_model, const FilterInput& input,
                          const EstimationOptions& options) {
  check(augmented_model, input, options);
  EstimationResult result = RecordRun(augmented_model, input, options).run(augmented_model.prior());
  for (int pass = 1; pass < options.passes && !result.failure; ++pass)
    result = RecordRun(augmented_model, input, options).run(next_prior(augmented_model, result));
  if (options.passes > 1 && !augmented_model.options().keep_initial_state)
    put_back(augmented_model.prior(), augmented_model, result);
  return result;
}

Interval confidence_interval(const ParameterTransform& transform, double state_mean, double state_deviation,
                             double probability) {
  const double width = normal_quantile(0.5 * (1.0 + probability)) * state_deviation;
  return {transform.to_parameter(state_mean - width), transform.to_parameter(state_mean + width)};
}

}  // namespace kalfem
