// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/change_threshold.hpp"

#include <cmath>
#include <numbers>

namespace kalfem {
namespace {

double normal_distribution(double x) { return 0.5 * std::erfc(-x * std::numbers::sqrt2 / 2.0); }

/// The correction for a random walk that is seen at whole steps only: of the excess over a boundary.
double excess_factor(double x) {
  if (x < 0.05) return std::exp(-0.583 * x);
  double sum = 0.0;
  for (int n = 1; 0.5 * x * std::sqrt(n) < 9.0; ++n) sum += normal_distribution(-0.5 * x * std::sqrt(n)) / n;
  return 2.0 / (x * x) * std::exp(-2.0 * sum);
}

}  // namespace

double false_alarm_rate(double threshold, int memory) {
  constexpr int parts = 60;  // Simpson's rule, smooth integrand
  const double from = threshold / std::sqrt(memory), step = (threshold - from) / parts;
  double integral = 0.0;
  for (int i = 0; i <= parts; ++i) {
    const double x = from + i * step, nu = excess_factor(x);
    integral += (i == 0 || i == parts ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * x * nu * nu;
  }
  integral *= step / 3.0;
  // With a memory of one window: the two tails alone.
  const double single = 2.0 * normal_distribution(-threshold);
  return single + threshold * std::exp(-0.5 * threshold * threshold) / std::sqrt(2.0 * std::numbers::pi) * integral;
}

double change_threshold(double windows, int memory, Eigen::Index parameters) {
  double low = 1.5, high = 40.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double expected = windows * static_cast<double>(parameters) * false_alarm_rate(middle, memory);
    (expected > 1.0 ? low : high) = middle;
  }
  return high;
}

}  // namespace kalfem
