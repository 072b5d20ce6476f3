// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/online_steps.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/live/state_file.hpp"
#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The problem with unknowns that may drift where changes of them are looked for.
FilterProblem made_for(const OnlineOptions& options, FilterProblem problem) {
  check(options, 1.0 / problem.problem->sample_rate);
  if (options.changes) let_drift(*options.changes, problem.setup.options.unknowns);
  return problem;
}

/// Value, rate and acceleration of input i in their rows.
void set_rows(Eigen::MatrixXd& inputs, Index i, const SignalSamples& samples) {
  const Index count = inputs.rows() / 3;
  for (Index derivative = 0; derivative < 3; ++derivative)
    inputs.row(derivative * count + i) = samples.col(derivative).matrix().transpose();
}

[[noreturn]] void refuse_not_finite(Index i) {
  throw InvalidInput("inputs[" + std::to_string(i) + "] is not finite", "the filter's model is driven by it",
                     "hold the last value where a sample is missing");
}

}  // namespace

OnlineSteps::OnlineSteps(FilterProblem problem, std::vector<OnlineInput> inputs, const OnlineOptions& options)
    : fingerprint_(state_fingerprint(problem, options)),
      inputs_(std::move(inputs)),
      loop_(made_for(options, std::move(problem)), options),
      delay_(inputs_.empty() ? 0 : options.input_delay),
      begun_(delay_ == 0 || std::ranges::all_of(inputs_, [](const auto& each) { return each.signal != nullptr; })) {
  if (options.changes) monitor_.emplace(*options.changes, loop_.unknown_options(), loop_.step());
}

void OnlineSteps::start(const std::vector<InputSample>& inputs) {
  loop_.set_inputs(stacked(inputs));
  begun_ = true;
}

void OnlineSteps::start(const VectorXd& values) {
  require_inputs(values);
  VectorXd inputs = VectorXd::Zero(3 * values.size());
  inputs.head(values.size()) = values;
  loop_.set_inputs(std::move(inputs));
}

bool OnlineSteps::predict(const std::vector<InputSample>& inputs) {
  const VectorXd next = stacked(inputs);
  if (loop_.failure()) return false;
  leave_splines();
  ++newest_;
  return loop_.move_along(course_to(next));
}

bool OnlineSteps::predict() {
  const Eigen::MatrixXd inputs = sampled_signals();
  if (loop_.failure()) return false;
  leave_splines();
  ++newest_;
  return loop_.move_along(inputs);
}

bool OnlineSteps::predict_values(const VectorXd& values) {
  require_inputs(values);
  if (loop_.failure()) return false;
  if (splines_.empty())
    for (Index i = 0; i < values.size(); ++i) splines_.emplace_back(loop_.inputs()[i], 1.0 / loop_.step());
  ++newest_;
  if (delay_ == 0) return loop_.move_to(straight_to(values));
  for (Index i = 0; i < values.size(); ++i) splines_[static_cast<std::size_t>(i)].add(values[i]);
  return follow(delay_);
}

bool OnlineSteps::update(const VectorXd& measured) {
  if (const auto sensors = std::ssize(loop_.sensors()); measured.size() != sensors)
    throw InvalidInput("update() is given " + std::to_string(measured.size()) + " values",
                       "there are " + std::to_string(sensors) + " sensors",
                       "give one a sensor, not a number where nothing was measured");
  if (loop_.failure()) return false;
  if (begun_ && loop_.sample() == newest_) return take(measured);
  waiting_.push_back({newest_, measured});
  return true;
}

bool OnlineSteps::take(const VectorXd& measured) {
  const bool taken = loop_.update(measured);
  if (monitor_) monitor_->after_sample(loop_);
  if (after_sample_) after_sample_();
  return taken;
}

/// Follows the newest sample at a distance.
bool OnlineSteps::follow(Index distance) {
  if (!begun_ && newest_ - loop_.sample() >= distance) begin();
  while (newest_ - loop_.sample() > distance && !loop_.failure()) {
    loop_.move_along(next_interval());
    take_waiting();
  }
  return !loop_.failure();
}

/// Takes the first sample, with the rates that the splines give its inputs.
void OnlineSteps::begin() {
  begun_ = true;
  const auto count = std::ssize(splines_);
  if (count > 0) {
    VectorXd inputs(3 * count);
    for (Index i = 0; i < count; ++i) {
      const SignalSamples samples = splines_[static_cast<std::size_t>(i)].first();
      for (Index derivative = 0; derivative < 3; ++derivative) inputs[derivative * count + i] = samples(0, derivative);
    }
    loop_.set_inputs(std::move(inputs));
  }
  take_waiting();
}

void OnlineSteps::take_waiting() {
  for (; !waiting_.empty() && waiting_.front().sample == loop_.sample(); waiting_.pop_front())
    take(waiting_.front().measured);
}

/// Before a prediction that needs no later samples.
void OnlineSteps::leave_splines() {
  if (newest_ != loop_.sample())
    throw InvalidInput(std::to_string(newest_ - loop_.sample()) + " samples of predict_values() wait for later ones",
                       "a prediction of another kind would come before them", "call finish() first");
  splines_.clear();
  if (!begun_) begin();
}

/// [r; r'; r''] from the present sample to the next.
Eigen::MatrixXd OnlineSteps::next_interval() {
  const auto count = std::ssize(splines_);
  const Index parts = loop_.instants();
  Eigen::MatrixXd inputs(3 * count, parts + 1);
  for (Index i = 0; i < count; ++i) set_rows(inputs, i, splines_[static_cast<std::size_t>(i)].move(parts));
  return inputs;
}

Eigen::MatrixXd OnlineSteps::sampled_signals() const {
  const Index parts = loop_.instants();
  Eigen::MatrixXd inputs(3 * count(), parts + 1);
  for (Index i = 0; i < count(); ++i) {
    const auto& [name, moves_ground, signal] = inputs_[static_cast<std::size_t>(i)];
    if (!signal)
      throw InvalidInput("input '" + name + "' has no signal", "predict() without arguments reads it",
                         "give the inputs to predict()");
    set_rows(inputs, i, signal->sample(loop_.time(), loop_.step() / static_cast<double>(parts), parts + 1));
  }
  return inputs;
}

/// [r; r'; r''] up to the next sample: of a moved ground the polynomial of the fifth degree with these at both ends,
/// of others, which act by their values alone, straight lines.
Eigen::MatrixXd OnlineSteps::course_to(const VectorXd& next) const {
  const VectorXd& now = loop_.inputs();
  const Index count = now.size() / 3, parts = loop_.instants();
  const double h = loop_.step();
  Eigen::MatrixXd inputs(3 * count, parts + 1);
  for (Index part = 0; part <= parts; ++part) {
    const double x = static_cast<double>(part) / static_cast<double>(parts);
    inputs.col(part) = (1.0 - x) * now + x * next;
    for (Index i = 0; i < count; ++i) {
      if (!inputs_[static_cast<std::size_t>(i)].moves_ground) continue;
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
VectorXd OnlineSteps::straight_to(const VectorXd& values) const {
  const Index count = values.size();
  const VectorXd& now = loop_.inputs();
  VectorXd next(3 * count);
  next.head(count) = values;
  next.segment(count, count) = (values - now.head(count)) / loop_.step();
  next.tail(count) = (next.segment(count, count) - now.segment(count, count)) / loop_.step();
  return next;
}

/// [r; r'; r''] of the filter's model.
VectorXd OnlineSteps::stacked(const std::vector<InputSample>& given) const {
  if (std::ssize(given) != count())
    throw InvalidInput(std::to_string(given.size()) + " inputs are given",
                       "the structure has " + std::to_string(count()), "give one sample for each of them");
  VectorXd inputs(3 * count());
  for (Index i = 0; i < count(); ++i) {
    const auto& [value, rate, acceleration] = given[static_cast<std::size_t>(i)];
    if (!std::isfinite(value) || !std::isfinite(rate) || !std::isfinite(acceleration)) refuse_not_finite(i);
    inputs[i] = value;
    inputs[count() + i] = rate;
    inputs[2 * count() + i] = acceleration;
  }
  return inputs;
}

void OnlineSteps::require_inputs(const VectorXd& values) const {
  if (values.size() != count())
    throw InvalidInput(std::to_string(values.size()) + " inputs are given",
                       "the structure has " + std::to_string(count()), "give one value for each of them");
  for (Index i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) refuse_not_finite(i);
}

void OnlineSteps::transfer(auto& self, auto& archive) {
  archive(self.begun_);
  archive(self.newest_);
  archive.each(self.splines_, [&](auto& spline) { StreamedSpline::transfer(spline, archive); });
  if (self.monitor_) ChangeMonitor::transfer(*self.monitor_, archive);
  archive.each(self.waiting_, [&](auto& each) {
    archive(each.sample);
    archive(each.measured);
  });
}

void OnlineSteps::keep(ArchiveWriter& archive) const {
  loop_.keep(archive);
  transfer(*this, archive);
}

void OnlineSteps::take_up(ArchiveReader& archive) {
  loop_.take_up(archive);
  transfer(*this, archive);
}

}  // namespace kalfem
