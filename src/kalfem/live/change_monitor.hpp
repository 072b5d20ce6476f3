// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/live/change_test.hpp"
#include "kalfem/live/covariate_samples.hpp"
#include "kalfem/live/daily_trend.hpp"
#include "kalfem/live/live_state.hpp"
#include "kalfem/live/monitored_unknown.hpp"
#include "kalfem/live/online_loop.hpp"
#include "kalfem/live/online_options.hpp"

namespace kalfem {

/// Watches the unknowns of a filter that runs by itself: forms what each window tells of them, corrects it for the
/// covariates, gives alarms on changes and keeps a trend by day.
///
/// After each window, 1. its information (window_information) goes to the test and to the trend, 2. the test says for
/// each unknown the most likely step, 3. one whose statistic exceeds the threshold, and whose size the level, in so
/// many windows in succession as `persistence` says, is accepted, the largest first, 4. alarms are raised and ended by
/// the sum of the accepted steps. Windows in which the filter warmed up, doubted itself or was silent are left out, as
/// are those without a value of every covariate.
class ChangeMonitor {
public:
  /// `step`: from sample to sample [s].
  ChangeMonitor(const ChangeOptions& options, const std::vector<UnknownParameter>& unknowns, double step);

  /// Of the first sample [s]: the days of the trend follow from it.
  void set_origin(double time) { origin_ = time; }
  /// The place of a covariate; nothing where there is none of that name.
  [[nodiscard]] std::optional<std::size_t> find(const std::string& covariate) const;
  /// A value at a time from the first sample on [s]. It must come before the filter has passed the end of its window.
  void add(std::size_t covariate, double time, double value) { covariates_[covariate].add(time, value); }
  /// The filter has taken a sample.
  void after_sample(const OnlineLoop& loop);

  [[nodiscard]] const ChangeOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<MonitoredUnknown>& unknowns() const { return unknowns_; }
  [[nodiscard]] double threshold() const { return threshold_; }   ///< of the statistic, in deviations
  [[nodiscard]] long windows() const { return test_.windows(); }  ///< that were used
  [[nodiscard]] long windows_left_out() const { return left_out_; }
  [[nodiscard]] const std::deque<Alarm>& alarms() const { return alarms_; }  ///< the latest 1000, the oldest first
  [[nodiscard]] std::int64_t alarms_given() const { return given_; }
  /// Parameters whose alarm has been raised and has not ended.
  [[nodiscard]] std::vector<ParameterChange> present_changes() const;
  [[nodiscard]] const ChangeTest& test() const { return test_; }
  [[nodiscard]] const std::vector<TrendDay>& days() const { return trend_.days(); }
  [[nodiscard]] std::vector<ParameterDay> parameters_of(const TrendDay& day) const;
  /// All days, with the present one, one entry for each unknown.
  [[nodiscard]] std::vector<ParameterDay> trend() const;

  static void transfer(auto& self, auto& archive) {
    archive(self.origin_);
    archive.each(self.covariates_, [&](auto& each) { CovariateSamples::transfer(each, archive); });
    archive.maybe(self.start_, [&](auto& start) {
      archive(start.mean);
      archive(start.covariance);
    });
    archive(self.changed_);
    archive(self.settled_);
    archive(self.left_out_);
    ChangeTest::transfer(self.test_, archive);
    DailyTrend::transfer(self.trend_, archive);
    archive(self.suspected_);
    archive(self.below_);
    archive(self.raised_);
    archive(self.suspects_);
    archive(self.given_);
    archive.each(self.alarms_, [&](auto& alarm) {
      archive(alarm.number);
      archive(alarm.kind);
      archive(alarm.time);
      archive(alarm.text);
      auto& what = alarm.what;
      archive(what.parameter);
      for (auto* number : {&what.change, &what.std, &what.lower, &what.upper, &what.since, &what.earliest, &what.latest,
                           &what.statistic})
        archive(*number);
    });
  }

private:
  [[nodiscard]] Gaussian relative_estimate(const OnlineLoop& loop) const;
  [[nodiscard]] Eigen::VectorXd covariate_means(double now);
  void close_window(double now, const Gaussian& end, const Eigen::VectorXd& covariates);
  void look_for_steps(double now);
  void end_alarms(double now);
  void give(AlarmKind kind, double now, Eigen::Index parameter);
  [[nodiscard]] ParameterChange change_of(Eigen::Index parameter) const;

  ChangeOptions options_;
  std::vector<MonitoredUnknown> unknowns_;
  long length_;  ///< of a window [samples]
  double step_;  ///< [s]
  double threshold_;
  double origin_ = 0.0;
  std::vector<CovariateSamples> covariates_;
  std::optional<Gaussian> start_;  ///< estimate at the start of the window, relative; empty: the window is left out
  long changed_ = -1;              ///< of the loop, at the start of the window
  int settled_ = 0;                ///< windows since the filter has warmed up
  long left_out_ = 0;
  ChangeTest test_;
  DailyTrend trend_;
  std::vector<int> suspected_, below_;  ///< windows in succession beyond the threshold, and below the level, by unknown
  std::vector<int> raised_;             ///< 1 where an alarm stands
  bool suspects_ = false;               ///< whether the last window exceeded the threshold somewhere
  std::int64_t given_ = 0;
  std::deque<Alarm> alarms_;
};

/// Lets every unknown that has no random walk follow a change of `level` within `memory` windows, so that the filter
/// does not hold what it found for good.
void let_drift(const ChangeOptions& options, std::vector<UnknownParameter>& unknowns);

}  // namespace kalfem
