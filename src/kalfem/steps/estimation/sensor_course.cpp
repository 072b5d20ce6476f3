// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/sensor_course.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/outcome.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index most_windows = 100;
constexpr Index least_window = 10;  ///< samples

Agreement agreement_of(double sum_of_squares, double count) {
  if (count == 0.0) return Agreement::missing;
  const auto within = [&](double probability) {
    const double tail = 0.5 * (1.0 - probability);
    return sum_of_squares >= chi_squared_quantile(tail, count) &&
           sum_of_squares <= chi_squared_quantile(1.0 - tail, count);
  };
  if (within(0.95)) return Agreement::green;
  if (sum_of_squares < count) return Agreement::small;
  return within(0.999) ? Agreement::amber : Agreement::red;
}

/// About the mean of what is there; 0 where it is missing.
VectorXd centred(const VectorXd& sequence) {
  const auto there = sequence.array().isFinite().eval();
  const double count = static_cast<double>(std::max<Index>(1, there.count()));
  const double mean = there.select(sequence.array(), 0.0).sum() / count;
  return there.select(sequence.array() - mean, 0.0);
}

}  // namespace

SensorCourse::SensorCourse(const EstimationOutcome& outcome, Index row)
    : name(outcome.measurements.channels[static_cast<std::size_t>(row)].name),
      unit(outcome.measurements.channels[static_cast<std::size_t>(row)].unit),
      measured(outcome.measurements.values.row(row).transpose()),
      innovation(outcome.result.innovation.row(row).transpose()),
      deviation(outcome.result.innovation_deviation.row(row).transpose()),
      expected(measured - innovation) {
  const Index from = std::min(outcome.settled, innovation.size() - 1);
  settled = innovation.cwiseQuotient(deviation).tail(innovation.size() - from);
  settled_at = outcome.measurements.time(from);
  const auto there = settled.array().isFinite().eval();
  known = there.count();
  const Index asked = std::max(least_window, settled.size() / most_windows);
  const Index length = std::clamp<Index>(settled.size(), 1, asked), count = settled.size() / length;
  window_length = static_cast<double>(length) / outcome.measurements.sample_rate;
  window_size.resize(count);
  const VectorXd squares = there.select(settled.array().square(), 0.0);
  for (Index w = 0; w < count; ++w) {
    const double sum = squares.segment(w * length, length).sum();
    const auto samples = static_cast<double>(there.segment(w * length, length).count());
    windows.push_back(agreement_of(sum, samples));
    window_size[w] = samples > 0.0 ? sum / samples : std::nan("");
  }
}

double SensorCourse::size() const {
  return std::sqrt(settled.array().isFinite().select(settled.array().square(), 0.0).sum() / static_cast<double>(known));
}

double SensorCourse::inside_95() const {
  return static_cast<double>((settled.array().abs() < normal_quantile(0.975)).count()) / static_cast<double>(known);
}

double SensorCourse::share(Agreement agreement) const {
  const auto with_data = windows.size() - static_cast<std::size_t>(std::ranges::count(windows, Agreement::missing));
  if (with_data == 0) return 0.0;
  return static_cast<double>(std::ranges::count(windows, agreement)) / static_cast<double>(with_data);
}

double SensorCourse::worst_time() const {
  Index worst = 0;
  for (Index w = 1; w < window_size.size(); ++w)
    if (!(window_size[w] <= window_size[worst])) worst = std::isfinite(window_size[w]) ? w : worst;
  return settled_at + (static_cast<double>(worst) + 0.5) * window_length;
}

std::vector<double> correlogram(const VectorXd& sequence, Index lags) {
  std::vector<double> values;
  const auto known = sequence.array().isFinite();
  if (known.count() < 4 * lags) return values;
  const VectorXd filled = known.select(sequence.array(), 0.0);
  for (Index lag = 0; lag <= lags; ++lag)
    values.push_back(filled.head(filled.size() - lag).dot(filled.tail(filled.size() - lag)) / filled.squaredNorm());
  return values;
}

std::vector<double> cross_correlogram(const VectorXd& a, const VectorXd& b, Index lags) {
  std::vector<double> values;
  const VectorXd first = centred(a), second = centred(b);
  const double size = first.norm() * second.norm();
  if (a.array().isFinite().count() < 4 * lags || !(size > 0.0)) return values;
  for (Index lag = 0; lag <= lags; ++lag)
    values.push_back(first.tail(first.size() - lag).dot(second.head(second.size() - lag)) / size);
  return values;
}

}  // namespace kalfem
