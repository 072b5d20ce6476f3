// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/online_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/estimation/failure.hpp"
#include "kalfem/estimation/filter_setup.hpp"
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

void require_online(const EstimateOptions& options) {
  IssueList issues;
  const auto refuse = [&](bool given, const char* name) {
    if (given)
      issues.add({}, std::string(name) + " needs a whole record", "an OnlineFilter does not know what follows",
                 "use estimate()");
  };
  refuse(options.initial_state_from_record, "initial_state_from_record");
  refuse(options.passes > 1, "passes");
  refuse(options.settle.has_value(), "settle");
  issues.raise();
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

/// The filter with its model and present state. predict() sets the inputs at both ends of the interval and predicts
/// over it. update() conditions on the sensors and, once the unknowns of the linear part have moved far enough,
/// relinearises the model. After a stop both return false and change nothing.
class OnlineFilter::Loop {
public:
  Loop(const Structure& structure, double sample_rate, const EstimateOptions& options,
       const std::vector<InputSample>& first)
      : signals_(structure.description().signals),
        sensors_(options.sensors),
        made_(make_filter_problem(with_signals(structure), sample_rate, options)),
        step_(1.0 / sample_rate) {
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
    inputs_ = first.empty() ? run.input.inputs.col(0) : stacked(first);
    const auto& inputs = structure.description().parts.inputs;
    for (std::size_t i = 0; i < inputs.size(); ++i)
      if (inputs[i].kind == InputKind::base_displacement) moved_grounds_.push_back(static_cast<Index>(i));
    innovation_ = VectorXd::Constant(noise_.rows(), not_a_number);
  }

  /// With inputs that are linear up to the next sample.
  bool predict(const VectorXd& inputs) {
    return move([&] { setup_->transition.set_inputs(inputs_, inputs); }, inputs);
  }

  /// With values of the inputs from which their derivatives follow.
  bool predict_values(const VectorXd& values) {
    require_inputs(values);
    const Index count = values.size();
    next_.setZero(3 * count);
    next_.head(count) = values;
    for (const Index i : moved_grounds_) {
      next_[count + i] = (values[i] - inputs_[i]) / step_;
      next_[2 * count + i] = (next_[count + i] - inputs_[count + i]) / step_;
    }
    return move([&] { setup_->transition.set_inputs(inputs_, next_); }, next_);
  }

  void start(const VectorXd& values) {
    require_inputs(values);
    inputs_.setZero(3 * values.size());
    inputs_.head(values.size()) = values;
  }

  /// With the signals at every substep of the interval.
  bool predict() {
    const Eigen::MatrixXd inputs = sampled_signals();
    return move([&] { setup_->transition.set_inputs(inputs); }, inputs.rightCols(1));
  }

  bool update(const VectorXd& measured) {
    if (measured.size() != noise_.rows())
      throw InvalidInput("update() is given " + std::to_string(measured.size()) + " values",
                         "there are " + std::to_string(noise_.rows()) + " sensors",
                         "give one a sensor, not a number where nothing was measured");
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
    if (innovation.channels.empty()) return true;
    innovation_(innovation.channels) = innovation.value;
    nis_ = innovation.nis;
    return linearise_where_it_moved();
  }

  /// [r; r'; r''] of the filter's model.
  [[nodiscard]] VectorXd stacked(const std::vector<InputSample>& given) const {
    const auto count = static_cast<Index>(signals_.size());
    if (given.size() != signals_.size())
      throw InvalidInput(std::to_string(given.size()) + " inputs are given",
                         "the structure has " + std::to_string(signals_.size()), "give one sample for each of them");
    VectorXd inputs(3 * count);
    for (Index i = 0; i < count; ++i) {
      const auto& [value, rate, acceleration] = given[static_cast<std::size_t>(i)];
      if (!std::isfinite(value) || !std::isfinite(rate) || !std::isfinite(acceleration))
        throw InvalidInput("inputs[" + std::to_string(i) + "] is not finite", "the filter's model is driven by it",
                           "hold the last value where a sample is missing");
      inputs[i] = value;
      inputs[count + i] = rate;
      inputs[2 * count + i] = acceleration;
    }
    return inputs;
  }

  [[nodiscard]] ParameterEstimate parameter(std::size_t i) const {
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

  [[nodiscard]] PresentEstimate observe(const std::string& name) {
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

  [[nodiscard]] const FilterProblem& made() const { return made_; }
  [[nodiscard]] std::size_t unknowns() const { return model_->options().unknowns.size(); }
  [[nodiscard]] bool in_physical_coordinates() const {
    return setup_->augmented_model->options().coordinates == StateCoordinates::physical;
  }
  [[nodiscard]] double time() const { return static_cast<double>(sample_) * step_; }
  [[nodiscard]] const std::optional<FilterStop>& failure() const { return failure_; }
  [[nodiscard]] const VectorXd& innovation() const { return innovation_; }
  [[nodiscard]] double nis() const { return nis_; }

private:
  void require_inputs(const VectorXd& values) const {
    if (values.size() != std::ssize(signals_))
      throw InvalidInput(std::to_string(values.size()) + " inputs are given",
                         "the structure has " + std::to_string(signals_.size()), "give one value for each of them");
    for (Index i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        throw InvalidInput("inputs[" + std::to_string(i) + "] is not finite", "the filter's model is driven by it",
                           "hold the last value where a sample is missing");
  }

  template <class SetInputs>
  bool move(const SetInputs& set_inputs, const VectorXd& next) {
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

  /// [r; r'; r''] from the present sample to the next.
  [[nodiscard]] Eigen::MatrixXd sampled_signals() const {
    const auto count = static_cast<Index>(signals_.size());
    const Index parts = model_->options().substeps;
    Eigen::MatrixXd inputs(3 * count, parts + 1);
    for (Index i = 0; i < count; ++i) {
      const auto& signal = signals_[static_cast<std::size_t>(i)];
      if (!signal)
        throw InvalidInput(
            "input '" + made_.problem->structure->parts.inputs[static_cast<std::size_t>(i)].name + "' has no signal",
            "predict() without arguments reads it", "give the inputs to predict()");
      const auto samples = signal->sample(time(), step_ / static_cast<double>(parts), parts + 1);
      for (Index derivative = 0; derivative < 3; ++derivative)
        inputs.row(derivative * count + i) = samples.col(derivative).matrix().transpose();
    }
    return inputs;
  }

  /// Makes a step of the filter; where the covariance has lost its sign in modal coordinates, once more in physical
  /// ones. A step that fails leaves the estimate as it was.
  template <class Step>
  bool went_on(const Step& step) {
    FilterOutcome outcome = step();
    if (outcome == FilterOutcome::covariance_not_positive_definite && use_physical_coordinates()) outcome = step();
    return stop_unless_usable(outcome);
  }

  bool stop_unless_usable(FilterOutcome outcome) {
    if (outcome != FilterOutcome::usable)
      failure_ = FilterStop{time(), to_string(outcome) + "; " + remedy_of(outcome, options_.filter)};
    return !failure_;
  }

  /// Carries the estimate over to a model in physical coordinates; false where it stands in these already or is not
  /// finite.
  bool use_physical_coordinates() {
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

  /// Values and deviations of the unknowns of the linear part, now or by their prior.
  [[nodiscard]] LinearEstimate linear_estimate(bool prior) const {
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

  bool linearise_where_it_moved() {
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

  std::vector<SignalPtr> signals_;
  std::vector<SensorDescription> sensors_;
  FilterProblem made_;
  double step_;  ///< [s]
  EstimationOptions options_;
  std::shared_ptr<const AugmentedModel> model_;  ///< at the start of the run
  std::unique_ptr<FilterSetup> setup_;
  std::vector<Index> linear_unknowns_;
  LinearEstimate linearised_about_;
  Eigen::MatrixXd noise_;
  VectorXd inputs_;  ///< at the present sample
  VectorXd next_;    ///< at the next one, while the filter moves there
  std::vector<Index> moved_grounds_;
  VectorXd innovation_;
  double nis_ = not_a_number;
  long sample_ = 0;
  std::optional<FilterStop> failure_;
};

OnlineFilter::OnlineFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
                           const std::vector<InputSample>& first) {
  require_online(options);
  loop_ = std::make_unique<Loop>(structure, sample_rate, options, first);
}
OnlineFilter::OnlineFilter(OnlineFilter&&) noexcept = default;
OnlineFilter& OnlineFilter::operator=(OnlineFilter&&) noexcept = default;
OnlineFilter::~OnlineFilter() = default;

bool OnlineFilter::predict(const std::vector<InputSample>& inputs) { return loop_->predict(loop_->stacked(inputs)); }
bool OnlineFilter::predict_values(const VectorXd& values) { return loop_->predict_values(values); }
void OnlineFilter::start(const VectorXd& values) { loop_->start(values); }
bool OnlineFilter::predict() { return loop_->predict(); }
bool OnlineFilter::update(const VectorXd& measured) { return loop_->update(measured); }

bool OnlineFilter::in_physical_coordinates() const { return loop_->in_physical_coordinates(); }
double OnlineFilter::time() const { return loop_->time(); }
const std::optional<FilterStop>& OnlineFilter::failure() const { return loop_->failure(); }

std::vector<ParameterEstimate> OnlineFilter::parameters() const {
  std::vector<ParameterEstimate> all;
  for (std::size_t i = 0; i < loop_->unknowns(); ++i) all.push_back(loop_->parameter(i));
  return all;
}

PresentEstimate OnlineFilter::parameter(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& each : parameters()) {
    if (each.name == name) return {each.mean, each.std};
    known.push_back(each.name);
  }
  throw InvalidInput("the filter has no parameter '" + name + "'" + did_you_mean(name, known), "", "");
}

PresentEstimate OnlineFilter::state(const std::string& name) { return loop_->observe(name); }
const VectorXd& OnlineFilter::innovation() const { return loop_->innovation(); }
double OnlineFilter::nis() const { return loop_->nis(); }

}  // namespace kalfem
