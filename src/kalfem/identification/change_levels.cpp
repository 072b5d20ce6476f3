// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/change_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double least_share = 1e-3;  ///< of what is known at the end of a stretch, for one that says anything
constexpr Index most_apart = 2;       ///< differences of neighbours that a sudden change may explain
constexpr int walks = 40;             ///< steps of a walk that are tried, by a factor of two in the variance

double sum_of_squares(const VectorXd& values, const VectorXd& weights) {
  if (values.size() == 0) return 0.0;
  const double mean = weights.dot(values) / weights.sum();
  return weights.dot((values.array() - mean).square().matrix());
}

/// Mean square of the differences between neighbours over what their variances let expect, without the largest ones.
double scatter_of(const StretchLevels& levels) {
  const Index count = levels.value.size() - 1;
  VectorXd squares(count);
  for (Index k = 0; k < count; ++k) {
    const double difference = levels.value[k + 1] - levels.value[k];
    squares[k] = difference * difference / (levels.variance[k] + levels.variance[k + 1]);
  }
  std::ranges::sort(squares);
  return std::max(1.0, squares.head(count - most_apart).mean());
}

/// -2 ln of the density of the values, but for a constant, about a random walk from a level that is not known.
double misfit_of_walk(const VectorXd& values, const VectorXd& variances, double walk) {
  double mean = values[0], variance = variances[0], misfit = 0.0;
  for (Index k = 1; k < values.size(); ++k) {
    variance += walk;
    const double innovation = values[k] - mean, expected = variance + variances[k], gain = variance / expected;
    misfit += innovation * innovation / expected + std::log(expected);
    mean += gain * innovation;
    variance *= 1.0 - gain;
  }
  return misfit;
}

double misfit_of_line(const VectorXd& values, const VectorXd& weights) {
  const VectorXd time = VectorXd::LinSpaced(values.size(), -1.0, 1.0);
  const double total = weights.sum(), middle = weights.dot(time) / total, mean = weights.dot(values) / total;
  const VectorXd t = time.array() - middle, y = values.array() - mean, wt = weights.cwiseProduct(t);
  const double slope = wt.dot(y) / wt.dot(t);
  return weights.dot((y - slope * t).cwiseAbs2());
}

/// The split of a series into two levels that leaves the least.
void set_contrast(const VectorXd& estimates, const VectorXd& weights, StretchLevels& levels) {
  const Index count = estimates.size();
  const double total = sum_of_squares(estimates, weights);
  for (Index k = 1; k < count; ++k) {
    const double left = sum_of_squares(estimates.head(k), weights.head(k)) +
                        sum_of_squares(estimates.tail(count - k), weights.tail(count - k));
    const double contrast = static_cast<double>(count - 2) * (total - left) / std::max(left, 1e-12 * total);
    if (contrast > levels.contrast) levels.contrast = contrast, levels.second_level = k;
  }
}

}  // namespace

StretchLevels levels_of(const EstimationResult& forgetting, Index row, double deviation, Index length, Index first) {
  StretchLevels levels{.length = length};
  if (forgetting.failure) return levels;
  const auto& [mean, spread] = forgetting.state;
  std::vector<double> values, variances, estimates, weights;
  for (Index begin = 0; begin + length <= mean.cols(); begin += length) {
    const Index end = begin + length - 1;
    const bool starts = begin == 0;
    const double before = starts ? forgetting.prior.mean[row] : mean(row, begin - 1);
    const double known =
        starts ? forgetting.prior.covariance(row, row) : spread(row, begin - 1) * spread(row, begin - 1);
    const double prior = 1.0 / (starts ? known : known + deviation * deviation);
    const double after = 1.0 / (spread(row, end) * spread(row, end));
    if (end <= first || !(after - prior > least_share * after)) continue;
    levels.end.push_back(end + 1);
    estimates.push_back(mean(row, end));
    weights.push_back(after);
    variances.push_back(1.0 / (after - prior));
    values.push_back(variances.back() * (after * mean(row, end) - prior * before));
  }
  const auto vector = [](const std::vector<double>& from) {
    return VectorXd(Eigen::Map<const VectorXd>(from.data(), static_cast<Index>(from.size())));
  };
  levels.value = vector(values);
  levels.variance = vector(variances);
  set_contrast(vector(estimates), vector(weights), levels);
  return levels;
}

LevelFits fits_of(const StretchLevels& levels) {
  constexpr Index fewest = 8;
  const Index count = levels.value.size();
  LevelFits fits;
  if (count < fewest) return fits;
  fits.scatter = scatter_of(levels);
  const VectorXd variances = fits.scatter * levels.variance, weights = variances.cwiseInverse();
  const double constant = sum_of_squares(levels.value, weights), number = std::log(static_cast<double>(count));
  for (Index k = 1; k + 1 < count; ++k) {
    const Index after = count - k - 1;
    const double left = sum_of_squares(levels.value.head(k), weights.head(k)) +
                        sum_of_squares(levels.value.tail(after), weights.tail(after));
    const double gain = constant - left - 3.0 * number;
    if (gain > fits.step) fits.step = gain, fits.place = k;
  }
  const double steady = misfit_of_walk(levels.value, variances, 0.0);
  const double largest = (levels.value.array() - levels.value.mean()).square().mean();
  double gain_of_walk = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < walks; ++i) {
    const double walk = std::ldexp(largest, -i), gain = steady - misfit_of_walk(levels.value, variances, walk) - number;
    if (gain > gain_of_walk) gain_of_walk = gain, fits.walk = walk;
  }
  const double gain_of_line = constant - misfit_of_line(levels.value, weights) - number;
  fits.slow = std::max({0.0, gain_of_walk, gain_of_line});
  return fits;
}

WalkedCourse smoothed_walk(const StretchLevels& levels, double walk, double scatter) {
  const Index count = levels.value.size();
  // The values are a walk plus white scatter: their precision is tridiagonal, and small enough to be inverted whole.
  Eigen::MatrixXd precision = (scatter * levels.variance).cwiseInverse().asDiagonal();
  const VectorXd known = precision * levels.value;
  for (Index k = 0; k + 1 < count; ++k) {
    precision(k, k) += 1.0 / walk;
    precision(k + 1, k + 1) += 1.0 / walk;
    precision(k, k + 1) -= 1.0 / walk;
    precision(k + 1, k) -= 1.0 / walk;
  }
  const Eigen::MatrixXd covariance = precision.inverse();
  const Index last = count - 1;
  return {.value = covariance * known,
          .deviation = covariance.diagonal().cwiseSqrt(),
          .change_deviation = std::sqrt(covariance(0, 0) + covariance(last, last) - 2.0 * covariance(0, last))};
}

}  // namespace kalfem
