// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/daily_trend.hpp"

#include <cmath>

namespace kalfem {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double a_day = 86'400.0;
constexpr std::size_t most_days = 3653;

}  // namespace

DailyTrend::DailyTrend(const VectorXd& prior) : prior_(prior) { begin(0.0); }

void DailyTrend::begin(double start) {
  start_ = start;
  windows_ = 0;
  information_.setZero(prior_.size(), prior_.size());
  weighted_.setZero(prior_.size());
  covariates_.resize(0);
}

void DailyTrend::add(double start, const WindowInformation& window, const VectorXd& covariates,
                     const ChangeTest& test) {
  const double day = a_day * std::floor(start / a_day);
  if (windows_ > 0 && day > start_) {
    days_.push_back(today(test));
    if (days_.size() > most_days) days_.erase(days_.begin());
    begin(day);
  }
  if (windows_ == 0) {
    start_ = day;
    covariates_.setZero(covariates.size());
  }
  ++windows_;
  information_ += window.information;
  weighted_ += window.weighted;
  covariates_ += test.relative(covariates);
}

TrendDay DailyTrend::today(const ChangeTest& test) const {
  TrendDay day{.start = start_, .windows = windows_};
  if (windows_ == 0) return day;
  MatrixXd information = information_;
  information.diagonal() += prior_.cwiseAbs2().cwiseInverse();
  const Eigen::LDLT<MatrixXd> factor(information);
  const VectorXd variance = factor.solve(MatrixXd::Identity(prior_.size(), prior_.size())).diagonal();
  const VectorXd relative = covariates_ / static_cast<double>(windows_);
  day.mean = factor.solve(weighted_);
  day.deviation = (test.scatter() * variance).cwiseSqrt();
  day.corrected = day.mean - test.effects() * relative;
  day.corrected_deviation = (test.scatter() * variance + test.effect_variance(relative)).cwiseSqrt();
  return day;
}

}  // namespace kalfem
