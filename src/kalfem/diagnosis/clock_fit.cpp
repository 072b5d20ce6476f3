// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/clock_fit.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/records/fractional_shift.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index parts = 12;
constexpr Index fewest_samples = 30;  ///< of a part
constexpr int most_steps = 8;         ///< of Gauss and Newton
constexpr double settled = 1e-3;      ///< samples that a step still moves

/// A row of the record beside its prediction: about their means, in units of the row's size, zero where either is
/// missing.
struct Pair {
  VectorXd y, x;
  Eigen::ArrayXd there;
};

VectorXd about_mean(const VectorXd& values, const Eigen::ArrayXd& there) {
  const double mean = (there > 0.0).select(values.array(), 0.0).sum() / there.sum();
  return (there > 0.0).select(values.array() - mean, 0.0);
}

std::optional<Pair> pair_of(const VectorXd& recorded, const VectorXd& predicted) {
  Pair pair;
  pair.there = (recorded.array().isFinite() && predicted.array().isFinite()).cast<double>();
  if (pair.there.sum() < static_cast<double>(fewest_samples)) return std::nullopt;
  pair.y = about_mean(recorded, pair.there);
  pair.x = about_mean(predicted, pair.there);
  const double size = pair.y.norm();
  if (!(size > 0.0) || !(pair.x.norm() > 0.0)) return std::nullopt;
  pair.y /= size;
  pair.x /= size;
  return pair;
}

/// sum_k y(k) x(k - lag) over the samples of each part; parts x lags from -most to most.
MatrixXd correlations(const std::vector<Pair>& pairs, Index most) {
  const Index samples = pairs.front().y.size();
  MatrixXd sums = MatrixXd::Zero(parts, 2 * most + 1);
  for (const auto& [y, x, there] : pairs)
    for (Index p = 0; p < parts; ++p) {
      const Index begin = p * samples / parts, end = (p + 1) * samples / parts;
      for (Index lag = -most; lag <= most; ++lag) {
        const Index from = std::max(begin, lag), to = std::min(end, samples + lag);
        if (to > from) sums(p, lag + most) += y.segment(from, to - from).dot(x.segment(from - lag, to - from));
      }
    }
  return sums;
}

/// Lags at the middles of the first and the last part for which the parts correlate most, on a straight line.
std::pair<Index, Index> best_ends(const MatrixXd& sums, Index most) {
  double highest = -1.0;
  std::pair<Index, Index> best{0, 0};
  for (Index first = -most; first <= most; ++first)
    for (Index last = -most; last <= most; ++last) {
      double sum = 0.0;
      for (Index p = 0; p < parts; ++p) {
        const Index above_least =
            (first + most) * (parts - 1 - p) + (last + most) * p;  // >= 0: rounded as it should be
        sum += sums(p, (above_least + (parts - 1) / 2) / (parts - 1));
      }
      if (std::abs(sum) <= highest) continue;
      highest = std::abs(sum);
      best = {first, last};
    }
  return best;
}

/// Least squares for the gain and for what is still missing of delay and drift, by prediction and slope at the times of
/// the clock so far.
struct Step {
  double gain = 0.0, delay = 0.0, drift = 0.0, delay_deviation = 0.0, drift_deviation = 0.0;
};

std::optional<Step> step_at(const std::vector<Pair>& pairs, double delay, double drift) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double of_y = 0.0, count = 0.0;
  for (const auto& [y, x, there] : pairs) {
    const Index samples = y.size();
    const VectorXd time = VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1));
    const VectorXd moved = shifted(x, VectorXd(-delay - drift * time.array()));
    for (Index k = 1; k + 1 < samples; ++k) {
      const double slope = 0.5 * (moved[k + 1] - moved[k - 1]);
      if (there[k] == 0.0 || !std::isfinite(slope) || !std::isfinite(moved[k])) continue;
      const Eigen::Vector3d row(moved[k], -slope, -slope * time[k]);
      normal += row * row.transpose();
      right += row * y[k];
      of_y += y[k] * y[k];
      count += 1.0;
    }
  }
  const Eigen::Vector3d scale = normal.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0) || count < static_cast<double>(fewest_samples)) return std::nullopt;
  const Eigen::Matrix3d inverse =
      (scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal()).inverse();
  const Eigen::Vector3d found =
      scale.cwiseInverse().asDiagonal() * (inverse * (scale.cwiseInverse().asDiagonal() * right));
  const double left = std::max(0.0, of_y - right.dot(found)) / (count - 3.0), gain = found[0];
  if (!(std::abs(gain) > 0.0)) return std::nullopt;
  const auto deviation = [&](int i) { return std::sqrt(left * inverse(i, i)) / scale[i] / std::abs(gain); };
  return Step{gain, found[1] / gain, found[2] / gain, deviation(1), deviation(2)};
}

}  // namespace

std::optional<ClockFit> fit_clock(const Eigen::Ref<const MatrixXd>& recorded,
                                  const Eigen::Ref<const MatrixXd>& predicted, Index most) {
  const Index samples = recorded.cols();
  if (predicted.cols() != samples || samples < parts * fewest_samples) return std::nullopt;
  std::vector<Pair> pairs;
  for (Index i = 0; i < recorded.rows(); ++i)
    if (auto pair = pair_of(recorded.row(i).transpose(), predicted.row(i).transpose()))
      pairs.push_back(std::move(*pair));
  if (pairs.empty()) return std::nullopt;
  const auto [first, last] = best_ends(correlations(pairs, most), most);
  const double slope = static_cast<double>(last - first) * parts / static_cast<double>(samples * (parts - 1));
  ClockFit fit{.delay = static_cast<double>(first) - 0.5 * slope * static_cast<double>(samples) / parts,
               .drift = slope};
  for (int i = 0; i < most_steps; ++i) {
    const auto step = step_at(pairs, fit.delay, fit.drift);
    if (!step) return std::nullopt;
    fit.delay += step->delay;
    fit.drift += step->drift;
    fit.delay_deviation = step->delay_deviation;
    fit.drift_deviation = step->drift_deviation;
    if (std::abs(step->delay) + std::abs(step->drift) * static_cast<double>(samples) < settled) break;
  }
  const double reach = 2.0 * static_cast<double>(most);
  const bool sound = std::abs(fit.delay) < reach && std::abs(fit.drift) * static_cast<double>(samples) < reach;
  return sound ? std::optional(fit) : std::nullopt;
}

}  // namespace kalfem
