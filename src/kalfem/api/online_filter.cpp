// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/online_filter.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/online_loop.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/system/signals/cubic_spline.hpp"
#include "kalfem/system/signals/streamed_spline.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

void require_online(const Structure& structure, const EstimateOptions& options) {
  IssueList issues;
  const auto& parts = structure.description().parts;
  const auto& signals = structure.description().signals;
  const auto& by_velocity = structure.description().by_velocity;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!signals[i] && std::ranges::find(by_velocity, parts.inputs[i].name) != by_velocity.end())
      issues.add({}, "input '" + parts.inputs[i].name + "' is given by its velocity sample by sample",
                 "its displacement would drift with the offset of the velocity, which only a whole record tells",
                 "integrate it behind a high-pass, and give a base_displacement");
  const auto refuse = [&](bool given, const char* name) {
    if (given)
      issues.add({}, std::string(name) + " needs a whole record", "an OnlineFilter does not know what follows",
                 "use estimate()");
  };
  refuse(options.initial_state_from_record, "initial_state_from_record");
  refuse(options.passes > 1, "passes");
  refuse(!options.known_to.empty(), "known_to");
  refuse(options.settle.has_value(), "settle");
  refuse_measurement_unknowns(options.unknowns, issues);
  issues.raise();
}

const OnlineOptions& checked(const OnlineOptions& online) {
  IssueList issues;
  if (online.input_delay < 0 || online.input_delay > 1000)
    issues.add({}, "input_delay: " + std::to_string(online.input_delay) + " samples",
               "the filter stays behind its inputs by that", "give a number from 0 to 1000; 8 is nearly exact");
  if (online.window < 100 || online.window > 10'000'000)
    issues.add({}, "window: " + std::to_string(online.window) + " samples",
               "the innovations of so many samples tell whether the filter is usable",
               "give a number from 100 to 10,000,000");
  issues.raise();
  return online;
}

/// Values that the sensors showed at a sample.
struct Waiting {
  long sample = 0;
  VectorXd measured;
};

}  // namespace

/// The filter, and the samples that wait for later inputs. Inputs that come as values pass through a spline each. Once
/// the newest sample is `input_delay` ahead, the filter begins at the first one, and then follows at this distance;
/// measurements wait in a queue until the filter stands at their sample.
class OnlineFilter::Steps {
public:
  Steps(const Structure& structure, double sample_rate, const EstimateOptions& options, const OnlineOptions& online)
      : signals_(structure.description().signals),
        loop_(structure, sample_rate, options, checked(online).window),
        sensors_(std::ssize(options.sensors)),
        delay_(signals_.empty() ? 0 : online.input_delay),
        begun_(delay_ == 0 || std::ranges::none_of(signals_, [](const SignalPtr& signal) { return !signal; })) {
    for (const auto& input : structure.description().parts.inputs) {
      if (input.kind == InputKind::base_displacement) moved_grounds_.push_back(std::ssize(names_));
      names_.push_back(input.name);
    }
  }

  void start(const std::vector<InputSample>& inputs) {
    loop_.set_inputs(stacked(inputs));
    begun_ = true;
  }

  void start(const VectorXd& values) {
    require_inputs(values);
    VectorXd inputs = VectorXd::Zero(3 * values.size());
    inputs.head(values.size()) = values;
    loop_.set_inputs(std::move(inputs));
  }

  bool predict(const std::vector<InputSample>& inputs) {
    const VectorXd next = stacked(inputs);
    if (loop_.failure()) return false;
    leave_splines();
    ++newest_;
    return loop_.move_along(course_to(next));
  }

  bool predict() {
    const Eigen::MatrixXd inputs = sampled_signals();
    if (loop_.failure()) return false;
    leave_splines();
    ++newest_;
    return loop_.move_along(inputs);
  }

  bool predict_values(const VectorXd& values) {
    require_inputs(values);
    if (loop_.failure()) return false;
    if (splines_.empty())
      for (Index i = 0; i < values.size(); ++i) splines_.emplace_back(loop_.inputs()[i], 1.0 / loop_.step());
    ++newest_;
    if (delay_ == 0) return loop_.move_to(straight_to(values));
    for (Index i = 0; i < values.size(); ++i) splines_[static_cast<std::size_t>(i)].add(values[i]);
    return follow(delay_);
  }

  bool update(const VectorXd& measured) {
    if (measured.size() != sensors_)
      throw InvalidInput("update() is given " + std::to_string(measured.size()) + " values",
                         "there are " + std::to_string(sensors_) + " sensors",
                         "give one a sensor, not a number where nothing was measured");
    if (loop_.failure()) return false;
    if (begun_ && loop_.sample() == newest_) return loop_.update(measured);
    waiting_.push_back({newest_, measured});
    return true;
  }

  /// Follows the newest sample at a distance.
  bool follow(Index distance) {
    if (!begun_ && newest_ - loop_.sample() >= distance) begin();
    while (newest_ - loop_.sample() > distance && !loop_.failure()) {
      loop_.move_along(next_interval());
      take_waiting();
    }
    return !loop_.failure();
  }

  [[nodiscard]] OnlineLoop& loop() { return loop_; }

private:
  /// Takes the first sample, with the rates that the splines give its inputs.
  void begin() {
    begun_ = true;
    const auto count = std::ssize(splines_);
    if (count > 0) {
      VectorXd inputs(3 * count);
      for (Index i = 0; i < count; ++i) {
        const SignalSamples samples = splines_[static_cast<std::size_t>(i)].first();
        for (Index derivative = 0; derivative < 3; ++derivative)
          inputs[derivative * count + i] = samples(0, derivative);
      }
      loop_.set_inputs(std::move(inputs));
    }
    take_waiting();
  }

  void take_waiting() {
    for (; !waiting_.empty() && waiting_.front().sample == loop_.sample(); waiting_.pop_front())
      loop_.update(waiting_.front().measured);
  }

  /// Before a prediction that needs no later samples.
  void leave_splines() {
    if (newest_ != loop_.sample())
      throw InvalidInput(std::to_string(newest_ - loop_.sample()) + " samples of predict_values() wait for later ones",
                         "a prediction of another kind would come before them", "call finish() first");
    splines_.clear();
    if (!begun_) begin();
  }

  /// [r; r'; r''] from the present sample to the next.
  Eigen::MatrixXd next_interval() {
    const auto count = std::ssize(splines_);
    const Index parts = loop_.instants();
    Eigen::MatrixXd inputs(3 * count, parts + 1);
    for (Index i = 0; i < count; ++i) set_rows(inputs, i, splines_[static_cast<std::size_t>(i)].move(parts));
    return inputs;
  }

  [[nodiscard]] Eigen::MatrixXd sampled_signals() const {
    const Index parts = loop_.instants();
    Eigen::MatrixXd inputs(3 * std::ssize(signals_), parts + 1);
    for (std::size_t i = 0; i < signals_.size(); ++i) {
      if (!signals_[i])
        throw InvalidInput("input '" + names_[i] + "' has no signal", "predict() without arguments reads it",
                           "give the inputs to predict()");
      set_rows(inputs, static_cast<Index>(i),
               signals_[i]->sample(loop_.time(), loop_.step() / static_cast<double>(parts), parts + 1));
    }
    return inputs;
  }

  /// Value, rate and acceleration of input i in their rows.
  static void set_rows(Eigen::MatrixXd& inputs, Index i, const SignalSamples& samples) {
    const Index count = inputs.rows() / 3;
    for (Index derivative = 0; derivative < 3; ++derivative)
      inputs.row(derivative * count + i) = samples.col(derivative).matrix().transpose();
  }

  /// [r; r'; r''] up to the next sample: of a moved ground the polynomial of the fifth degree with these at both ends,
  /// of others, which act by their values alone, straight lines.
  [[nodiscard]] Eigen::MatrixXd course_to(const VectorXd& next) const {
    const VectorXd& now = loop_.inputs();
    const Index count = now.size() / 3, parts = loop_.instants();
    const double h = loop_.step();
    Eigen::MatrixXd inputs(3 * count, parts + 1);
    for (Index part = 0; part <= parts; ++part) {
      const double x = static_cast<double>(part) / static_cast<double>(parts);
      inputs.col(part) = (1.0 - x) * now + x * next;
      for (const Index i : moved_grounds_) {
        const auto [value, slope, curvature] =
            hermite_segment({now[i], h * now[count + i], h * h * now[2 * count + i]},
                            {next[i], h * next[count + i], h * h * next[2 * count + i]}, x);
        inputs(i, part) = value;
        inputs(count + i, part) = slope / h;
        inputs(2 * count + i, part) = curvature / (h * h);
      }
    }
    return inputs;
  }

  /// The next sample's inputs, with the differences from the present ones as rates and accelerations.
  [[nodiscard]] VectorXd straight_to(const VectorXd& values) const {
    const Index count = values.size();
    const VectorXd& now = loop_.inputs();
    VectorXd next(3 * count);
    next.head(count) = values;
    next.segment(count, count) = (values - now.head(count)) / loop_.step();
    next.tail(count) = (next.segment(count, count) - now.segment(count, count)) / loop_.step();
    return next;
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
      if (!std::isfinite(value) || !std::isfinite(rate) || !std::isfinite(acceleration)) refuse_not_finite(i);
      inputs[i] = value;
      inputs[count + i] = rate;
      inputs[2 * count + i] = acceleration;
    }
    return inputs;
  }

  void require_inputs(const VectorXd& values) const {
    if (values.size() != std::ssize(signals_))
      throw InvalidInput(std::to_string(values.size()) + " inputs are given",
                         "the structure has " + std::to_string(signals_.size()), "give one value for each of them");
    for (Index i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i])) refuse_not_finite(i);
  }

  [[noreturn]] static void refuse_not_finite(Index i) {
    throw InvalidInput("inputs[" + std::to_string(i) + "] is not finite", "the filter's model is driven by it",
                       "hold the last value where a sample is missing");
  }

  std::vector<SignalPtr> signals_;
  std::vector<std::string> names_;    ///< of the inputs
  std::vector<Index> moved_grounds_;  ///< places of these among the inputs
  OnlineLoop loop_;
  Index sensors_, delay_;
  bool begun_;                           ///< whether the filter has taken, or may take, the first sample
  long newest_ = 0;                      ///< sample of the last prediction that was asked for
  std::vector<StreamedSpline> splines_;  ///< one an input, while inputs come as values
  std::deque<Waiting> waiting_;
};

OnlineFilter::OnlineFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
                           const OnlineOptions& online) {
  require_online(structure, options);
  steps_ = std::make_unique<Steps>(structure, sample_rate, options, online);
}
OnlineFilter::OnlineFilter(OnlineFilter&&) noexcept = default;
OnlineFilter& OnlineFilter::operator=(OnlineFilter&&) noexcept = default;
OnlineFilter::~OnlineFilter() = default;

void OnlineFilter::start(const std::vector<InputSample>& inputs) { steps_->start(inputs); }
void OnlineFilter::start(const VectorXd& values) { steps_->start(values); }
bool OnlineFilter::predict(const std::vector<InputSample>& inputs) { return steps_->predict(inputs); }
bool OnlineFilter::predict() { return steps_->predict(); }
bool OnlineFilter::predict_values(const VectorXd& values) { return steps_->predict_values(values); }
bool OnlineFilter::update(const VectorXd& measured) { return steps_->update(measured); }
bool OnlineFilter::finish() { return steps_->follow(0); }

bool OnlineFilter::in_physical_coordinates() const { return steps_->loop().in_physical_coordinates(); }
double OnlineFilter::time() const { return steps_->loop().time(); }
const std::optional<FilterStop>& OnlineFilter::failure() const { return steps_->loop().failure(); }
const Verdict& OnlineFilter::verdict() const { return steps_->loop().window().verdict(); }
ConsistencySummary OnlineFilter::consistency() const { return steps_->loop().window().consistency(); }

std::vector<ParameterEstimate> OnlineFilter::parameters() const {
  std::vector<ParameterEstimate> all;
  for (std::size_t i = 0; i < steps_->loop().unknowns(); ++i) all.push_back(steps_->loop().parameter(i));
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

PresentEstimate OnlineFilter::state(const std::string& name) { return steps_->loop().observe(name); }
const VectorXd& OnlineFilter::innovation() const { return steps_->loop().innovation(); }
double OnlineFilter::nis() const { return steps_->loop().nis(); }

}  // namespace kalfem
