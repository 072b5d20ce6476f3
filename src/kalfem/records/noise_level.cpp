// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/noise_level.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double third_difference_gain = 20.0;
constexpr double mean_log_chi_squared = -1.2704;  ///< E[ln z^2] of a standard normal z
constexpr double median_chi_squared = 0.4549;     ///< median of z^2

/// Squared third differences, channels x samples - 3; NaN where a sample is missing.
ArrayXXd third_difference_power(const MatrixXd& values) {
  const Index n = values.cols() - 3;
  return (values.rightCols(n) - values.leftCols(n) - 3.0 * (values.middleCols(2, n) - values.middleCols(1, n)))
      .array()
      .square();
}

std::vector<double> finite_values(const Eigen::Ref<const ArrayXd>& channel) {
  std::vector<double> finite;
  for (const double value : channel)
    if (std::isfinite(value)) finite.push_back(value);
  return finite;
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A floor keeps the zeros of coarsely digitised channels from outweighing everything.
ArrayXXd log_power(const MatrixXd& values) {
  ArrayXXd power = third_difference_power(values);
  for (Index c = 0; c < power.rows(); ++c) {
    auto finite = finite_values(power.row(c).transpose());
    if (finite.empty()) continue;
    const double floor = std::max({1e-6 * median(finite), 1e-16 * *std::ranges::max_element(finite), 1e-300});
    power.row(c) = (power.row(c) + floor).log();
  }
  return power;
}

ArrayXd deviation_of(const ArrayXd& mean_log_power) {
  return (0.5 * (mean_log_power - mean_log_chi_squared)).exp() / std::sqrt(third_difference_gain);
}

}  // namespace

ArrayXd noise_level(const MatrixXd& values) {
  ArrayXd level = ArrayXd::Zero(values.rows());
  if (values.cols() < 4) return level;
  const ArrayXXd power = third_difference_power(values);
  for (Index c = 0; c < power.rows(); ++c) {
    auto finite = finite_values(power.row(c).transpose());
    level[c] = std::sqrt(median(finite) / median_chi_squared / third_difference_gain);
  }
  return level;
}

NoiseChange strongest_noise_change(const MatrixXd& values, Index shortest) {
  const ArrayXXd power = log_power(values);
  const auto finite = power.isFinite();
  const ArrayXXd present = finite.cast<double>(), known = finite.select(power, 0.0);
  const ArrayXd total = known.rowwise().sum(), total_count = present.rowwise().sum();
  ArrayXd sum = ArrayXd::Zero(power.rows()), count = sum, best_before = sum, best_after = sum;
  Index sample = 0;
  double best = -1.0;
  for (Index k = 0; k < power.cols() - shortest; ++k) {
    sum += known.col(k);
    count += present.col(k);
    if (k + 1 < shortest) continue;
    const ArrayXd before = sum / count.max(1.0), after = (total - sum) / (total_count - count).max(1.0);
    const double gain = ((after - before).square() * count * (total_count - count) / total_count.max(1.0)).sum();
    if (gain <= best) continue;
    best = gain, sample = k + 2, best_before = before, best_after = after;
  }
  return {sample, deviation_of(best_before), deviation_of(best_after)};
}

}  // namespace kalfem
