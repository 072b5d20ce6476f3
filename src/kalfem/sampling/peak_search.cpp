// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/peak_search.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "kalfem/base/interruption.hpp"

// Differences take a twentieth of a deviation by the approximate inverse Hessian, so they follow the width of the
// posterior, which may be a thousandth of the prior's.

namespace kalfem {
namespace {

/// Backtracks until the rise is a small part of what the slope promises.
bool search_line(const LogDensity& log_density, Peak& peak, const Eigen::VectorXd& direction, double slope) {
  for (double length = 1.0; length > 1e-10; length *= 0.5) {
    const Eigen::VectorXd z = peak.z + length * direction;
    const double value = log_density(z)[0];
    if (!(value >= peak.value + 1e-4 * length * slope)) continue;
    peak.z = z;
    peak.value = value;
    return true;
  }
  return false;
}

/// The update of Broyden, Fletcher, Goldfarb and Shanno; s: step, y: fall of the gradient.
void update_inverse(Eigen::MatrixXd& inverse, const Eigen::VectorXd& s, const Eigen::VectorXd& y) {
  const double sy = s.dot(y);
  if (!(sy > 1e-12 * s.norm() * y.norm())) return;
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(s.size(), s.size()) - s * y.transpose() / sy;
  inverse = left * inverse * left.transpose() + s * s.transpose() / sy;
}

Peak climb(const LogDensity& log_density, const Eigen::VectorXd& start, const LaplaceOptions& options) {
  Peak peak{.z = start, .value = log_density(start)[0], .inverse = {}};
  if (!std::isfinite(peak.value)) return peak;
  const auto differences = [&](const Eigen::VectorXd& steps) {
    return Differences(log_density(cross_points(peak.z, steps)), peak.value, steps);
  };
  const auto steps = [&] {
    return Eigen::VectorXd((0.05 * peak.inverse.diagonal().cwiseSqrt()).cwiseMax(1e-7).cwiseMin(0.02));
  };
  const auto from_curvature = [](const Eigen::VectorXd& curvature) {
    return Eigen::MatrixXd(curvature.cwiseAbs().cwiseMax(1.0).cwiseInverse().asDiagonal());
  };
  peak.inverse = from_curvature(differences(Eigen::VectorXd::Constant(start.size(), 1e-3)).curvature);
  Differences now = differences(steps());
  bool fresh = true;  // the inverse is a diagonal one
  for (int k = 0; k < options.max_iterations; ++k) {
    stop_if_asked();
    const Eigen::VectorXd direction = peak.inverse * now.gradient;
    const double slope = now.gradient.dot(direction);
    peak.converged = 0.5 * slope < options.decrement;
    if (peak.converged) break;
    const Eigen::VectorXd before = peak.z;
    if (!search_line(log_density, peak, direction, slope)) {
      if (fresh) break;
      peak.inverse = from_curvature(now.curvature);
      fresh = true;
      continue;
    }
    const Differences next = differences(steps());
    fresh = false;
    update_inverse(peak.inverse, peak.z - before, now.gradient - next.gradient);
    now = next;
  }
  return peak;
}

std::vector<Eigen::VectorXd> starts_of(const JointPrior& prior, const LaplaceOptions& options) {
  std::vector<Eigen::VectorXd> starts = {options.start ? prior.to_standard_normal(*options.start)
                                                       : Eigen::VectorXd(Eigen::VectorXd::Zero(prior.size()))};
  RandomStream random(options.seed, "laplace starts");
  for (int k = 0; k < options.random_starts; ++k) {
    starts.emplace_back(prior.size());
    for (auto& value : starts.back()) value = random.normal();
  }
  return starts;
}

bool apart(const Peak& one, const Peak& other) {
  const Eigen::VectorXd distance = (one.z - other.z).cwiseQuotient(other.inverse.diagonal().cwiseSqrt());
  return distance.cwiseAbs().maxCoeff() > 1.0;
}

}  // namespace

std::vector<Peak> find_peaks(const LogDensity& log_density, const JointPrior& prior, const LaplaceOptions& options) {
  if (options.start && options.start->size() != prior.size())
    throw InvalidInput("the start has " + std::to_string(options.start->size()) + " values",
                       "one for each of the " + std::to_string(prior.size()) + " parameters", "give one each");
  std::vector<Peak> found;
  for (const auto& start : starts_of(prior, options))
    if (Peak peak = climb(log_density, start, options); std::isfinite(peak.value)) found.push_back(std::move(peak));
  if (found.empty())
    throw InvalidInput("no start has a likelihood", "the search for the maximum has nowhere to begin",
                       "give a start where the model is possible, or more random starts");
  std::stable_sort(found.begin(), found.end(), [](const Peak& a, const Peak& b) { return a.value > b.value; });
  std::vector<Peak> peaks;
  for (auto& peak : found)
    if (peaks.empty() || (peak.converged && std::all_of(peaks.begin(), peaks.end(),
                                                        [&](const Peak& before) { return apart(peak, before); })))
      peaks.push_back(std::move(peak));
  return peaks;
}

}  // namespace kalfem
