// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/online_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/system/signals/sampled.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Zero at all times, instead of a signal whose values come online.
SignalPtr silence() {
  return make_sampled(VectorXd::Zero(2), {.interpolation = Interpolation::linear, .beyond = BeyondRecord::hold});
}

/// The structure with a signal for every input, so that its model can be made.
Structure with_signals(const Structure& structure) {
  auto description = structure.description();
  for (auto& signal : description.signals)
    if (!signal) signal = silence();
  return Structure(description);
}

/// With substeps where none are given: on hours of samples, forces at four instants leave a bias of a few standard
/// deviations.
EstimateOptions with_substeps(const EstimateOptions& options) {
  EstimateOptions online = options;
  if (!online.substeps) online.substeps = online.step_order == 4 ? 4 : 8;
  return online;
}

/// A record of one missing sample, from which the filter's model is made.
Record no_record(double sample_rate, const std::vector<SensorDescription>& sensors) {
  const auto count = static_cast<Index>(sensors.size());
  Record record{.sample_rate = sample_rate, .values = VectorXd::Constant(count, not_a_number)};
  for (const auto& sensor : sensors) record.channels.push_back({sensor.name, unit_of(sensor.output), sensor.noise});
  return record;
}

/// The nearest covariance of the same variances' scale: eigenvalues of the correlations that rounding has made negative
/// become 0. A few roundings more keep its factor real. Not a number where the covariance is not finite.
Eigen::MatrixXd without_negative_directions(const Eigen::MatrixXd& covariance) {
  constexpr double rounding = 1e-13;
  if (!covariance.allFinite()) return covariance;
  const VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd inverse = (scale.array() > 0.0).select(scale.cwiseInverse(), 0.0);
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (correlation + correlation.transpose()));
  const double floor = rounding * static_cast<double>(scale.size());
  const VectorXd values = eigen.eigenvalues().cwiseMax(floor);
  const Eigen::MatrixXd root = scale.asDiagonal() * eigen.eigenvectors() * values.cwiseSqrt().asDiagonal();
  return root * root.transpose();
}

}  // namespace

OnlineLoop::OnlineLoop(const Structure& structure, double sample_rate, const EstimateOptions& options, Index window)
    : sensors_(options.sensors),
      made_(make_filter_problem(with_signals(structure), sample_rate, with_substeps(options))),
      step_(1.0 / sample_rate),
      nis_(not_a_number),
      window_(options.sensors, sample_rate, window) {
  const FilterRun run = make_filter_run(made_.problem, made_.setup, no_record(sample_rate, options.sensors));
  model_ = run.choice.augmented_model;
  noise_ = run.input.noise;
  options_.filter = run.choice.filter;
  options_.threads = filter_threads(made_.problem->settings);
  options_.monitored = make_outputs(*made_.setup.model, made_.monitored);
  linear_unknowns_ = linear_unknowns(model_->options());
  setup_ = std::make_unique<FilterSetup>(model_, noise_, options_);
  setup_->filter->reset(model_->prior());
  linearised_about_ = linear_estimate(true);
  inputs_ = run.input.inputs.col(0);
  innovation_ = VectorXd::Constant(noise_.rows(), not_a_number);
}

template <class SetInputs>
bool OnlineLoop::move(const SetInputs& set_inputs, const VectorXd& next) {
  if (failure_) return false;
  ++sample_;
  const bool moved = went_on([&] {
    set_inputs();
    if (!linear_unknowns_.empty()) setup_->transition.set_mean(setup_->filter->mean());
    return setup_->filter->predict();
  });
  inputs_ = next;
  return moved;
}

bool OnlineLoop::move_to(const VectorXd& inputs) {
  return move([&] { setup_->transition.set_inputs(inputs_, inputs); }, inputs);
}

bool OnlineLoop::move_along(const Eigen::MatrixXd& inputs) {
  return move([&] { setup_->transition.set_inputs(inputs); }, inputs.rightCols(1));
}

bool OnlineLoop::update(const VectorXd& measured) {
  if (failure_) return false;
  innovation_.setConstant(not_a_number);
  nis_ = not_a_number;
  Innovation innovation;
  const auto condition = [&] {
    setup_->measurement.set_inputs(inputs_);
    if (!linear_unknowns_.empty()) setup_->measurement.set_mean(setup_->filter->mean());
    return setup_->filter->update(measured, innovation);
  };
  if (!went_on(condition)) return false;
  window_.add(time(), innovation);
  if (innovation.channels.empty()) return true;
  innovation_(innovation.channels) = innovation.value;
  nis_ = innovation.nis;
  return linearise_where_it_moved();
}

ParameterEstimate OnlineLoop::parameter(std::size_t i) const {
  const auto& unknown = model_->options().unknowns[i];
  const Index row = model_->layout().unknown() + static_cast<Index>(i);
  const double state = setup_->filter->mean()[row], deviation = setup_->filter->standard_deviation()[row];
  const auto interval = confidence_interval(unknown.transform, state, deviation);
  return {.name = unknown.name,
          .unit = unknown.unit,
          .mean = unknown.transform.to_parameter(state),
          .std = unknown.transform.slope(state) * deviation,
          .interval_95 = {interval.lower, interval.upper}};
}

PresentEstimate OnlineLoop::observe(const std::string& name) {
  const auto found = std::ranges::find(made_.monitored, name, &OutputDescription::name);
  if (found == made_.monitored.end()) {
    std::vector<std::string> known;
    for (const auto& each : made_.monitored) known.push_back(each.name);
    throw InvalidInput("the filter has no state '" + name + "'" + did_you_mean(name, known), "", "");
  }
  auto& monitored = *setup_->monitored;
  monitored.set_inputs(inputs_);
  if (!linear_unknowns_.empty()) monitored.set_mean(setup_->filter->mean());
  VectorXd mean, deviation;
  if (setup_->filter->observe(mean, &deviation) != FilterOutcome::usable) return {not_a_number, not_a_number};
  const auto row = found - made_.monitored.begin();
  return {mean[row], deviation[row]};
}

bool OnlineLoop::in_physical_coordinates() const {
  return setup_->augmented_model->options().coordinates == StateCoordinates::physical;
}

template <class Step>
bool OnlineLoop::went_on(const Step& step) {
  FilterOutcome outcome = step();
  if (outcome == FilterOutcome::covariance_not_positive_definite && use_physical_coordinates()) outcome = step();
  return stop_unless_usable(outcome);
}

bool OnlineLoop::stop_unless_usable(FilterOutcome outcome) {
  if (outcome != FilterOutcome::usable)
    failure_ = FilterStop{time(), to_string(outcome) + "; " + remedy_of(outcome, options_.filter)};
  return !failure_;
}

bool OnlineLoop::use_physical_coordinates() {
  const AugmentedModel& now = *setup_->augmented_model;
  if (now.options().coordinates != StateCoordinates::modal) return false;
  const Gaussian here{now.physical(setup_->filter->mean()),
                      without_negative_directions(now.physical_covariance(setup_->filter->covariance()))};
  if (!here.mean.allFinite() || !here.covariance.allFinite()) return false;
  const double rate = made_.problem->sample_rate;
  model_ = make_filter_run(made_.problem, made_.setup, no_record(rate, sensors_), StateCoordinates::physical)
               .choice.augmented_model;
  auto about = model_;
  if (!linear_unknowns_.empty())
    about =
        std::make_shared<const AugmentedModel>(model_->about(linearised_about_.values, linearised_about_.deviations));
  setup_ = std::make_unique<FilterSetup>(about, noise_, options_);
  setup_->filter->reset(here);
  return true;
}

LinearEstimate OnlineLoop::linear_estimate(bool prior) const {
  const auto count = static_cast<Index>(linear_unknowns_.size());
  LinearEstimate estimate{VectorXd(count), VectorXd(count)};
  for (Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(linear_unknowns_[static_cast<std::size_t>(i)]);
    const auto& unknown = model_->options().unknowns[at];
    const auto now = prior ? ParameterEstimate{{}, {}, unknown.initial, unknown.deviation} : parameter(at);
    estimate.values[i] = now.mean;
    estimate.deviations[i] = now.std;
  }
  return estimate;
}

bool OnlineLoop::linearise_where_it_moved() {
  if (linear_unknowns_.empty()) return true;
  auto now = linear_estimate(false);
  if (!now.outdates(linearised_about_)) return true;
  try {
    setup_ = relinearised(*model_, now, *setup_, noise_, options_);
  } catch (const InvalidInput&) {
    return stop_unless_usable(FilterOutcome::linear_part_impossible);
  }
  linearised_about_ = std::move(now);
  return true;
}

}  // namespace kalfem
