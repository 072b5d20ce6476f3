// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/online_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kalfem/base/resumable.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/unknown_inputs.hpp"
#include "kalfem/live/three_digits.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr long between_looks = 128;       ///< samples, at how far unknowns have walked
constexpr double beyond_the_prior = 1.1;  ///< deviations of the prior, from where on an unknown is held

/// A record of one missing sample, from which the filter's model is made.
Record no_record(double sample_rate, const std::vector<Sensor>& sensors) {
  const auto count = static_cast<Index>(sensors.size());
  Record record{.sample_rate = sample_rate, .values = VectorXd::Constant(count, not_a_number)};
  for (const auto& sensor : sensors) record.channels.push_back({sensor.name, sensor.unit, sensor.noise});
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

bool is_physical(const AugmentedModel& model) { return model.options().coordinates == StateCoordinates::physical; }

std::vector<Index> every_channel(Index count) {
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

std::vector<GatedSensor> gated_sensors(const std::vector<Sensor>& sensors) {
  std::vector<GatedSensor> gated;
  for (const auto& sensor : sensors) gated.push_back({sensor.name, sensor.unit, sensor.noise});
  return gated;
}

}  // namespace

OnlineLoop::OnlineLoop(FilterProblem problem, const OnlineOptions& options)
    : made_(std::move(problem)),
      step_(1.0 / made_.problem->sample_rate),
      nis_(not_a_number),
      window_(made_.setup.sensors, made_.problem->sample_rate, options.window),
      health_(step_),
      gates_(options.gates.value_or(GateOptions{})),
      gated_(options.gates.has_value()),
      gate_(gates_, gated_sensors(made_.setup.sensors)) {
  const FilterRun run =
      make_filter_run(made_.problem, made_.setup, no_record(made_.problem->sample_rate, made_.setup.sensors));
  model_ = run.choice.augmented_model;
  noise_ = run.input.noise;
  options_.filter = run.choice.filter;
  options_.unscented = made_.problem->settings.unscented;
  options_.threads = filter_threads(made_.problem->settings);
  options_.monitored = with_inputs(make_outputs(*made_.setup.model, made_.monitored),
                                   held_by(made_.problem->settings.unknown_inputs, made_.setup), *made_.setup.model);
  linear_unknowns_ = linear_unknowns(model_->options());
  setup_ = std::make_unique<FilterSetup>(model_, noise_, options_);
  setup_->filter->reset(model_->prior());
  prior_deviation_ =
      setup_->filter->standard_deviation().segment(model_->layout().unknown(), model_->layout().unknowns);
  linearised_about_ = linear_estimate(true);
  lag_ = FixedLag(options.lag, model_->layout().size(), options_);
  lag_.use(place(), *setup_);
  last_consistent_ = LastConsistent(*model_, model_->prior());
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
    lag_.before_prediction(*setup_);
    return setup_->filter->predict();
  });
  inputs_ = next;
  if (!moved) return false;
  if (changed_ == sample_)
    lag_.begin(*setup_, sample_, inputs_);
  else
    lag_.after_prediction(*setup_, sample_, inputs_);
  return true;
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
  taken_ = measured;
  Innovation innovation;
  bool gated = false;
  const auto condition = [&] {
    setup_->measurement.set_inputs(inputs_);
    if (!linear_unknowns_.empty()) setup_->measurement.set_mean(setup_->filter->mean());
    if (gated_ && !gated) {
      // With every channel held out nothing is learned: what the filter expects of them all.
      const auto outcome = setup_->filter->update(measured, expected_, every_channel(measured.size()));
      if (outcome != FilterOutcome::usable) return outcome;
      gate_channels(measured);
      gated = true;
    }
    lag_.before_update(*setup_);
    return setup_->filter->update(taken_, innovation);
  };
  const long changed_before = changed_;
  if (!went_on(condition)) return false;
  if (changed_ != changed_before) return true;  // it has begun anew
  lag_.after_update(*setup_, innovation, sample_, inputs_);
  if (gated_ && sample_ % between_looks == 0) hold_at_prior();
  const bool judged = window_.add(time(), innovation);
  if (judged || gate_.changes() != seen_changes_) renew_verdict();
  if (gated_ && gate_.blames_filter())
    doubt_itself("most sensors have contradicted the filter for " + std::to_string(gates_.patience) + " samples");
  else if (gated_ && has_become_wrong())
    doubt_itself("its innovations, once consistent, have not been so for " + std::to_string(gates_.patience) +
                 " samples");
  if (health_.add(innovation.nis, std::ssize(innovation.channels))) health_.look(this->condition(), verdict_);
  if (innovation.channels.empty()) return true;
  innovation_(innovation.channels) = innovation.value;
  nis_ = innovation.nis;
  return linearise_where_it_moved();
}

void OnlineLoop::gate_channels(const VectorXd& measured) {
  if (expected_.set_aside.empty()) {
    gate_.miss(time());
    return;
  }
  expected_.channels.clear();
  for (const auto& each : expected_.set_aside) expected_.channels.push_back(each.channel);
  for (const Index channel : gate_.refused(time(), measured, expected_)) taken_[channel] = not_a_number;
}

void OnlineLoop::form_verdict() {
  seen_changes_ = gate_.changes();
  verdict_ = Verdict();
  verdict_.add(window_.reasons());
  verdict_.add(gate_.reasons());
}

/// A window in which nothing is wrong is what the filter can begin anew from.
void OnlineLoop::renew_verdict() {
  form_verdict();
  if (!gated_ || gate_.warms_up() || !window_.judges() || verdict_.state() != VerdictState::consistent) return;
  last_consistent_.remember(*setup_->augmented_model, estimate());
  was_consistent_ = true;
}

/// Whether the window, which was consistent before, has been unusable for so long that the structure must have changed.
/// Of a model that has never been consistent nobody can say that it has become wrong.
bool OnlineLoop::has_become_wrong() {
  const bool wrong = was_consistent_ && std::ranges::any_of(window_.reasons(), [](const Reason& reason) {
                       return reason.state == VerdictState::unusable;
                     });
  unusable_ = wrong ? unusable_ + 1 : 0;
  return unusable_ >= gates_.patience;
}

/// While the structure is at rest no sample tells of its unknowns, and the deviation of one that walks at random would
/// grow without end. It is held at that of its prior, at the correlations that it has; its mean stays.
void OnlineLoop::hold_at_prior() {
  const Index first = model_->layout().unknown(), count = model_->layout().unknowns;
  const VectorXd now = setup_->filter->standard_deviation().segment(first, count);
  if ((now.array() <= beyond_the_prior * prior_deviation_.array()).all()) return;
  Gaussian held = estimate();
  VectorXd scale = VectorXd::Ones(held.mean.size());
  scale.segment(first, count) = prior_deviation_.cwiseQuotient(now).cwiseMin(1.0);
  held.covariance = scale.asDiagonal() * held.covariance * scale.asDiagonal();
  setup_->filter->reset(held);
  lag_.begin(*setup_, sample_, inputs_);
}

/// It has been too sure of itself. Where wider deviations would explain what most sensors show, it is given them;
/// otherwise, and where it has not become consistent since it was last changed, it begins anew.
void OnlineLoop::doubt_itself(const std::string& why) {
  const bool explained = gate_.contradiction() <= gates_.inflation * gates_.inflation;
  const bool helped = was_consistent_ || changed_ < 0;
  if (!explained || !helped) {
    begin_anew(why);
    return;
  }
  Gaussian now = estimate();
  now.covariance = widened(now.covariance, gates_.inflation, model_->layout().unknown(), model_->prior().covariance);
  setup_->filter->reset(now);
  was_changed(FilterEventKind::inflated,
              why + "; its deviations are made up to " + three_digits(gates_.inflation) + " times as large");
}

void OnlineLoop::was_changed(FilterEventKind how, const std::string& text) {
  changed_ = sample_;
  was_consistent_ = false;
  unusable_ = 0;
  lag_.begin(*setup_, sample_, inputs_);
  gate_.filter_was_changed(time(), how, text);
}

/// False where it has begun anew only just before, so that it would not help.
bool OnlineLoop::begin_anew(const std::string& why) {
  if (!gated_ || (changed_ >= 0 && sample_ - changed_ < gates_.warm_up)) return false;
  setup_->filter->reset(last_consistent_.again(*setup_->augmented_model, gates_.inflation));
  was_changed(FilterEventKind::restarted, why + "; it begins anew from its last consistent estimate");
  return true;
}

FilterCondition OnlineLoop::condition() const {
  using enum FilterCondition;
  if (failure_) return unusable;
  if (gated_ && gate_.is_silent()) return silent;
  if (!gate_.trusts_any() || verdict_.state() == VerdictState::unusable) return unusable;
  if (!window_.judges() || (gated_ && gate_.warms_up())) return warming_up;
  return verdict_.state() == VerdictState::suspicious ? suspicious : consistent;
}

PresentParameter OnlineLoop::parameter(std::size_t i) const {
  const Index row = model_->layout().unknown() + static_cast<Index>(i);
  return parameter_of(i, setup_->filter->mean()[row], setup_->filter->standard_deviation()[row]);
}

PresentParameter OnlineLoop::parameter_of(std::size_t i, double state, double deviation) const {
  const auto& unknown = model_->options().unknowns[i];
  const auto interval = confidence_interval(unknown.transform, state, deviation);
  return {.name = unknown.name,
          .unit = unknown.unit,
          .mean = unknown.transform.to_parameter(state),
          .std = unknown.transform.slope(state) * deviation,
          .lower = interval.lower,
          .upper = interval.upper};
}

std::optional<SmoothedEstimate> OnlineLoop::smoothed() {
  const auto* found = lag_.smoothed();
  if (!found) return {};
  SmoothedEstimate smoothed{.time = static_cast<double>(found->sample) * step_};
  for (std::size_t i = 0; i < unknowns(); ++i) {
    const auto row = static_cast<Index>(i);
    smoothed.parameters.push_back(parameter_of(i, found->unknowns[row], found->unknowns_deviation[row]));
  }
  Index row = 0;
  for (const auto& name : options_.monitored.names) {
    smoothed.outputs.push_back({name, {found->outputs[row], found->outputs_deviation[row]}});
    ++row;
  }
  return smoothed;
}

Gaussian OnlineLoop::unknown_states() const {
  const Index first = model_->layout().unknown(), count = model_->layout().unknowns;
  return {setup_->filter->mean().segment(first, count),
          Eigen::MatrixXd(setup_->filter->covariance()).block(first, first, count, count)};
}

std::vector<std::string> OnlineLoop::observed() const { return options_.monitored.names; }

std::vector<PresentEstimate> OnlineLoop::observe_all() {
  std::vector<PresentEstimate> all(options_.monitored.names.size(), {not_a_number, not_a_number});
  if (all.empty()) return all;
  auto& monitored = *setup_->monitored;
  monitored.set_inputs(inputs_);
  if (!linear_unknowns_.empty()) monitored.set_mean(setup_->filter->mean());
  VectorXd mean, deviation;
  if (setup_->filter->observe(mean, &deviation) != FilterOutcome::usable) return all;
  for (Index row = 0; row < mean.size(); ++row) all[static_cast<std::size_t>(row)] = {mean[row], deviation[row]};
  return all;
}

PresentEstimate OnlineLoop::observe(const std::string& name) {
  const auto known = observed();
  const auto found = std::ranges::find(known, name);
  if (found == known.end())
    throw InvalidInput("the filter has no state '" + name + "'" + did_you_mean(name, known), "", "");
  return observe_all()[static_cast<std::size_t>(found - known.begin())];
}

bool OnlineLoop::in_physical_coordinates() const { return is_physical(*setup_->augmented_model); }

template <class Step>
bool OnlineLoop::went_on(const Step& step) {
  FilterOutcome outcome = step();
  if (outcome == FilterOutcome::covariance_not_positive_definite && use_physical_coordinates()) outcome = step();
  return stop_unless_usable(outcome);
}

bool OnlineLoop::stop_unless_usable(FilterOutcome outcome) {
  if (outcome == FilterOutcome::usable) return true;
  if (!begin_anew("it could not go on: " + to_string(outcome)))
    failure_ = FilterStop{time(), to_string(outcome) + "; " + remedy_of(outcome, options_.filter)};
  return !failure_;
}

bool OnlineLoop::use_physical_coordinates() {
  const AugmentedModel& now = *setup_->augmented_model;
  if (now.options().coordinates != StateCoordinates::modal) return false;
  const Gaussian here{now.physical(setup_->filter->mean()),
                      without_negative_directions(now.physical_covariance(setup_->filter->covariance()))};
  if (!here.mean.allFinite() || !here.covariance.allFinite()) return false;
  model_ = run_start_model(true);
  setup_ = std::make_unique<FilterSetup>(about_the_estimate(), noise_, options_);
  setup_->filter->reset(here);
  lag_.use(place(), *setup_);
  return true;
}

/// The model with which the run started, or would have in physical coordinates.
std::shared_ptr<const AugmentedModel> OnlineLoop::run_start_model(bool physical) const {
  return make_filter_run(made_.problem, made_.setup, no_record(made_.problem->sample_rate, made_.setup.sensors),
                         physical ? std::optional(StateCoordinates::physical) : std::nullopt)
      .choice.augmented_model;
}

std::shared_ptr<const AugmentedModel> OnlineLoop::about_the_estimate() const {
  if (linear_unknowns_.empty()) return model_;
  return std::make_shared<const AugmentedModel>(model_->about(linearised_about_.values, linearised_about_.deviations));
}

ModelPlace OnlineLoop::place() const {
  return {in_physical_coordinates(), setup_->augmented_model != model_, linearised_about_};
}

std::shared_ptr<const AugmentedModel> OnlineLoop::model_at(const ModelPlace& place) const {
  const auto& [physical, relinearised, about] = place;
  auto start = physical == is_physical(*model_) ? model_ : run_start_model(physical);
  if (!relinearised) return start;
  if (std::ssize(linear_unknowns_) != about.values.size()) throw DamagedArchive();
  return std::make_shared<const AugmentedModel>(start->about(about.values, about.deviations));
}

// What is kept: where the model stands (coordinates, values that it is linearised about), the filter's own numbers,
// then everything that the loop remembers. The model itself is made anew from the structure.
void OnlineLoop::transfer(auto& self, auto& archive) {
  archive(self.inputs_);
  archive(self.innovation_);
  archive(self.nis_);
  archive(self.sample_);
  archive.maybe(self.failure_, [&](auto& failure) {
    archive(failure.time);
    archive(failure.reason);
  });
  InnovationWindow::transfer(self.window_, archive);
  HealthSpans::transfer(self.health_, archive);
  SensorGate::transfer(self.gate_, archive);
  LastConsistent::transfer(self.last_consistent_, archive);
  archive(self.changed_);
  archive(self.was_consistent_);
  archive(self.unusable_);
}

void OnlineLoop::keep(ArchiveWriter& archive) const {
  archive(in_physical_coordinates());
  archive(relinearised_);
  archive(linearised_about_.values);
  archive(linearised_about_.deviations);
  dynamic_cast<const Resumable&>(*setup_->filter).keep(archive);
  transfer(*this, archive);
  lag_.keep(archive);
}

void OnlineLoop::take_up(ArchiveReader& archive) {
  bool physical = false;
  archive(physical);
  archive(relinearised_);
  archive(linearised_about_.values);
  archive(linearised_about_.deviations);
  if (std::ssize(linear_unknowns_) != linearised_about_.values.size()) throw DamagedArchive();
  if (physical && !in_physical_coordinates()) model_ = run_start_model(true);
  setup_ = std::make_unique<FilterSetup>(relinearised_ ? about_the_estimate() : model_, noise_, options_);
  setup_->filter->reset(setup_->augmented_model->prior());
  dynamic_cast<Resumable&>(*setup_->filter).take_up(archive);
  transfer(*this, archive);
  lag_.take_up(archive, [this](const ModelPlace& place) { return model_at(place); });
  form_verdict();
}

LinearEstimate OnlineLoop::linear_estimate(bool prior) const {
  const auto count = static_cast<Index>(linear_unknowns_.size());
  LinearEstimate estimate{VectorXd(count), VectorXd(count)};
  for (Index i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(linear_unknowns_[static_cast<std::size_t>(i)]);
    const auto& unknown = model_->options().unknowns[at];
    const auto now = prior ? PresentParameter{.mean = unknown.initial, .std = unknown.deviation} : parameter(at);
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
  relinearised_ = true;
  lag_.use(place(), *setup_);
  return true;
}

}  // namespace kalfem
