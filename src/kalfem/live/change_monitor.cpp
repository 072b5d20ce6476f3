// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/change_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/live/change_threshold.hpp"
#include "kalfem/live/three_digits.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr int settling = 2;            ///< windows after the filter has warmed up that are left out
constexpr double held_windows = 10.0;  ///< for which the last value of a covariate is held
constexpr std::size_t most_alarms = 1000;
constexpr std::size_t most_steps = 100;  ///< that are accepted
constexpr double deviations_95 = 1.96;

VectorXd prior_deviations(const std::vector<MonitoredUnknown>& unknowns) {
  VectorXd deviations(std::ssize(unknowns));
  for (Index i = 0; i < deviations.size(); ++i) deviations[i] = unknowns[static_cast<std::size_t>(i)].deviation;
  return deviations;
}

VectorXd effects_of(const ChangeOptions& options) {
  VectorXd effects(std::ssize(options.covariates));
  for (Index k = 0; k < effects.size(); ++k) effects[k] = options.covariates[static_cast<std::size_t>(k)].effect;
  return effects;
}

DailyMean mean_of(const MonitoredUnknown& unknown, double mean, double deviation) {
  const double lower = unknown.value(mean - deviations_95 * deviation);
  const double upper = unknown.value(mean + deviations_95 * deviation);
  return {unknown.value(mean), (upper - lower) / (2.0 * deviations_95), lower, upper};
}

std::string per_cent(double part) { return three_digits(100.0 * part) + " %"; }

}  // namespace

void let_drift(const ChangeOptions& options, std::vector<UnknownParameter>& unknowns) {
  for (auto& unknown : unknowns)
    if (unknown.random_walk == 0.0)
      unknown.random_walk =
          options.level * MonitoredUnknown(unknown).scale / std::sqrt(options.memory * options.window);
}

ChangeMonitor::ChangeMonitor(const ChangeOptions& options, const std::vector<UnknownParameter>& unknowns, double step)
    : options_(options),
      unknowns_(unknowns.begin(), unknowns.end()),
      length_(std::max(1L, std::lround(options.window / step))),
      step_(step),
      threshold_(change_threshold(options.false_alarms_every / options.window, options.memory, std::ssize(unknowns))),
      covariates_(options.covariates.size()),
      test_(prior_deviations(unknowns_), effects_of(options), options.memory),
      trend_(prior_deviations(unknowns_)),
      suspected_(unknowns_.size(), 0),
      below_(unknowns_.size(), 0),
      raised_(unknowns_.size(), 0) {}

std::optional<std::size_t> ChangeMonitor::find(const std::string& covariate) const {
  const auto found = std::ranges::find(options_.covariates, covariate, &Covariate::name);
  if (found == options_.covariates.end()) return {};
  return static_cast<std::size_t>(found - options_.covariates.begin());
}

Gaussian ChangeMonitor::relative_estimate(const OnlineLoop& loop) const {
  Gaussian estimate = loop.unknown_states();
  for (Index i = 0; i < estimate.mean.size(); ++i) {
    const auto& unknown = unknowns_[static_cast<std::size_t>(i)];
    estimate.mean[i] = (estimate.mean[i] - unknown.initial_state) * unknown.per_state;
    estimate.covariance.row(i) *= unknown.per_state;
    estimate.covariance.col(i) *= unknown.per_state;
  }
  return estimate;
}

void ChangeMonitor::after_sample(const OnlineLoop& loop) {
  if (loop.sample() % length_ != 0) return;
  using enum FilterCondition;
  const auto condition = loop.condition();
  const bool goes_on = !loop.failure() && condition != silent && loop.changed() == changed_;
  Gaussian here = relative_estimate(loop);
  const VectorXd covariates = covariate_means(loop.time());
  if (start_ && goes_on) close_window(loop.time(), here, covariates);
  if (start_ && !goes_on) ++left_out_;
  settled_ = goes_on && condition != warming_up ? settled_ + 1 : 0;
  start_.reset();
  if (settled_ > settling) start_ = std::move(here);
  changed_ = loop.changed();
}

/// Over the window that ends now; not a number where a covariate has had no value for long.
VectorXd ChangeMonitor::covariate_means(double now) {
  const double length = static_cast<double>(length_) * step_;
  VectorXd means(std::ssize(covariates_));
  for (Index k = 0; k < means.size(); ++k)
    means[k] = covariates_[static_cast<std::size_t>(k)].mean(now - length, now, held_windows * length);
  return means;
}

void ChangeMonitor::close_window(double now, const Gaussian& end, const VectorXd& values) {
  const double length = static_cast<double>(length_) * step_;
  VectorXd walk(std::ssize(unknowns_));
  for (Index i = 0; i < walk.size(); ++i) {
    const double each = unknowns_[static_cast<std::size_t>(i)].walk;
    walk[i] = each * each * length;
  }
  if (!values.allFinite() || !end.covariance.allFinite()) {
    ++left_out_;
    return;
  }
  const auto told = window_information(*start_, walk, end);
  const auto learning = suspects_                              ? ScatterLearning::none
                        : test_.windows() < options_.reference ? ScatterLearning::fully
                                                               : ScatterLearning::limited;
  test_.add(now - length, told, values, learning);
  trend_.add(origin_ + now - length, told, values, test_);
  if (test_.windows() >= options_.reference) look_for_steps(now);
}

void ChangeMonitor::look_for_steps(double now) {
  const auto steps = test_.likely_steps();
  suspects_ = false;
  const ParameterStep* found = nullptr;
  for (const auto& step : steps) {
    int& count = suspected_[static_cast<std::size_t>(step.parameter)];
    count = step.statistic > threshold_ ? count + 1 : 0;
    suspects_ = suspects_ || count > 0;
    const bool large = std::abs(step.change) >= options_.level;
    if (count >= options_.persistence && large && (!found || step.statistic > found->statistic)) found = &step;
  }
  if (found && test_.accepted().size() < most_steps) {
    const auto place = static_cast<std::size_t>(found->parameter);
    test_.accept(*found);
    suspected_[place] = 0;
    const bool stands =
        std::abs(test_.total_change(found->parameter).change) >= (1.0 - options_.hysteresis) * options_.level;
    if (stands) give(raised_[place] != 0 ? AlarmKind::changed : AlarmKind::raised, now, found->parameter);
    if (stands) raised_[place] = 1;
  }
  end_alarms(now);
}

void ChangeMonitor::end_alarms(double now) {
  for (std::size_t i = 0; i < raised_.size(); ++i) {
    if (raised_[i] == 0) continue;
    const auto parameter = static_cast<Index>(i);
    const double size = std::abs(test_.total_change(parameter).change);
    below_[i] = size < (1.0 - options_.hysteresis) * options_.level ? below_[i] + 1 : 0;
    if (below_[i] < options_.persistence) continue;
    below_[i] = raised_[i] = 0;
    give(AlarmKind::ended, now, parameter);
  }
}

ParameterChange ChangeMonitor::change_of(Index parameter) const {
  const auto total = test_.total_change(parameter);
  return {.parameter = unknowns_[static_cast<std::size_t>(parameter)].name,
          .change = total.change,
          .std = total.deviation,
          .lower = total.change - deviations_95 * total.deviation,
          .upper = total.change + deviations_95 * total.deviation,
          .since = total.since,
          .earliest = total.earliest,
          .latest = total.latest,
          .statistic = total.statistic};
}

std::vector<ParameterChange> ChangeMonitor::present_changes() const {
  std::vector<ParameterChange> all;
  for (std::size_t i = 0; i < raised_.size(); ++i)
    if (raised_[i] != 0) all.push_back(change_of(static_cast<Index>(i)));
  return all;
}

void ChangeMonitor::give(AlarmKind kind, double now, Index parameter) {
  Alarm alarm{.number = ++given_, .kind = kind, .time = now, .what = change_of(parameter)};
  const auto& what = alarm.what;
  const std::string of_it = what.parameter + " has changed by " + per_cent(what.change) + " (" + per_cent(what.lower) +
                            " to " + per_cent(what.upper) + ")";
  alarm.text = kind == AlarmKind::ended ? "the alarm on " + what.parameter + " has ended: its change is " +
                                              per_cent(what.change) + ", less than the level"
                                        : of_it;
  alarms_.push_back(std::move(alarm));
  if (alarms_.size() > most_alarms) alarms_.pop_front();
}

std::vector<ParameterDay> ChangeMonitor::parameters_of(const TrendDay& day) const {
  std::vector<ParameterDay> all;
  for (Index i = 0; i < day.mean.size(); ++i) {
    const auto& unknown = unknowns_[static_cast<std::size_t>(i)];
    all.push_back({.day = day.start,
                   .parameter = unknown.name,
                   .unit = unknown.unit,
                   .measured = mean_of(unknown, day.mean[i], day.deviation[i]),
                   .corrected = mean_of(unknown, day.corrected[i], day.corrected_deviation[i]),
                   .windows = day.windows});
  }
  return all;
}

std::vector<ParameterDay> ChangeMonitor::trend() const {
  std::vector<ParameterDay> all;
  const auto add = [&](const TrendDay& day) { std::ranges::move(parameters_of(day), std::back_inserter(all)); };
  for (const auto& day : trend_.days()) add(day);
  add(trend_.today(test_));
  return all;
}

}  // namespace kalfem
