// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/live/change_test.hpp"

namespace kalfem {

/// The parameters over one day, relative as in ChangeTest.
struct TrendDay {
  double start = 0.0;               ///< of the day [s]
  long windows = 0;                 ///< that were used
  Eigen::VectorXd mean, deviation;  ///< weighted mean of the windows' own estimates, p
  /// The same less the effects of the covariates, as if they had the values of the first window.
  Eigen::VectorXd corrected, corrected_deviation;
};

/// Means of the windows' estimates by day: (sum Lambda)^-1 sum eta, with the variance scatter (sum Lambda)^-1.
class DailyTrend {
public:
  /// `prior`: deviations of the parameters, for those of which a day tells nothing, p.
  explicit DailyTrend(const Eigen::VectorXd& prior);

  /// Takes a window that starts at a time [s]; the test has it already.
  void add(double start, const WindowInformation& window, const Eigen::VectorXd& covariates, const ChangeTest& test);
  /// Days that are over, the oldest first, ten years at most.
  [[nodiscard]] const std::vector<TrendDay>& days() const { return days_; }
  /// The day that is not over; without windows where none has begun.
  [[nodiscard]] TrendDay today(const ChangeTest& test) const;

  static void transfer(auto& self, auto& archive) {
    archive(self.start_);
    archive(self.windows_);
    archive(self.information_);
    archive(self.weighted_);
    archive(self.covariates_);
    archive.each(self.days_, [&](auto& day) {
      archive(day.start);
      archive(day.windows);
      for (auto* vector : {&day.mean, &day.deviation, &day.corrected, &day.corrected_deviation}) archive(*vector);
    });
  }

private:
  void begin(double start);

  Eigen::VectorXd prior_;
  double start_ = 0.0;  ///< of the present day [s]
  long windows_ = 0;
  Eigen::MatrixXd information_;  ///< p x p
  Eigen::VectorXd weighted_;     ///< p
  Eigen::VectorXd covariates_;   ///< sum over the windows, relative
  std::vector<TrendDay> days_;
};

}  // namespace kalfem
