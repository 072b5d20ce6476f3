// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/isolated_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "kalfem/records/noise_level.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr std::size_t window = 7;  ///< samples
constexpr double far = 8.0;        ///< standard deviations: beyond any noise, and what smooth motions do in a window
constexpr double normal_mad = 1.4826;
constexpr double least_part = 0.01;  ///< of the channel's range

/// The finite samples of a channel, and where they are.
struct Finite {
  std::vector<double> values;
  std::vector<Index> samples;
};

Finite finite_of(const MatrixXd& values, Index channel) {
  Finite finite;
  for (Index k = 0; k < values.cols(); ++k) {
    if (!std::isfinite(values(channel, k))) continue;
    finite.values.push_back(values(channel, k));
    finite.samples.push_back(k);
  }
  return finite;
}

double quantile(std::vector<double> values, double part) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, place);
  return *place;
}

/// How far a value may be from the median of its window, and how far it is.
struct Distance {
  double is = 0.0, allowed = 0.0;
};

Distance distance_from_neighbours(const std::vector<double>& values, std::size_t at) {
  const std::size_t begin = std::min(at - std::min(at, window / 2), values.size() - window);
  std::array<double, window> part;
  std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(begin), window, part.begin());
  const auto middle = part.begin() + window / 2;
  std::ranges::nth_element(part, middle);
  const double median = *middle;
  for (double& each : part) each = std::abs(each - median);
  std::ranges::nth_element(part, middle);
  return {std::abs(values[at] - median), far * normal_mad * *middle};
}

}  // namespace

MatrixXd without_isolated_values(const MatrixXd& values) {
  MatrixXd kept = values;
  const Eigen::ArrayXd noise = noise_level(values);
  for (Index c = 0; c < values.rows(); ++c) {
    const Finite finite = finite_of(values, c);
    if (finite.values.size() < window) continue;
    const double range = quantile(finite.values, 0.95) - quantile(finite.values, 0.05);
    const double least = std::max(far * noise[c], least_part * range);
    for (std::size_t i = 0; i < finite.values.size(); ++i) {
      const auto [distance, allowed] = distance_from_neighbours(finite.values, i);
      if (distance > std::max(allowed, least)) kept(c, finite.samples[i]) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return kept;
}

}  // namespace kalfem
