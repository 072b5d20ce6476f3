// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/peak_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "kalfem/base/interruption.hpp"

// 1. climb() from each start: BFGS, unless joined() finds that it has come into the reach of a peak that is known.
// 2. add() its end to the peaks, unless one_peak() says that it is known.
// 3. Samples of the prior are taken one after the other until enough in a row have told nothing new.
//
// Differences take a twentieth of a deviation by the approximate inverse Hessian, so they follow the width of the
// posterior, which may be a thousandth of the prior's.

namespace kalfem {
namespace {

constexpr int settled_starts = 60;   ///< in a row that found no new peak: one with 5 % of the prior is excluded
constexpr double shallow = 0.5;      ///< a dip of ln f between two ends that does not make two peaks of them
constexpr double negligible = 14.0;  ///< ln of a million

/// The squared distance of z from a peak in its deviations.
double squared_distance(const Peak& peak, const Eigen::VectorXd& z) {
  const Eigen::VectorXd away = z - peak.z;
  return away.dot(peak.inverse.ldlt().solve(away));
}

/// The peak in whose parabola z lies; null without one.
const Peak* joined(const std::vector<Peak>& known, const Eigen::VectorXd& z, double value) {
  for (const auto& peak : known) {
    if (!peak.converged) continue;
    const double square = squared_distance(peak, z);
    if (square < 4.0 && std::abs(value - (peak.value - 0.5 * square)) < shallow) return &peak;
  }
  return nullptr;
}

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

}  // namespace

Peak climb(const LogDensity& log_density, const Eigen::VectorXd& start, const LaplaceOptions& options,
           const std::vector<Peak>& known) {
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
    if (const Peak* peak_here = joined(known, peak.z, peak.value)) return *peak_here;
    const Differences next = differences(steps());
    fresh = false;
    update_inverse(peak.inverse, peak.z - before, now.gradient - next.gradient);
    now = next;
  }
  return peak;
}

namespace {

/// Half the logarithm of the determinant of the inverse, beside ln f: the peak's mass but for a constant.
double log_mass(const Peak& peak) {
  return peak.value + 0.5 * peak.inverse.ldlt().vectorD().array().max(1e-300).log().sum();
}

bool apart(const Peak& one, const Peak& other) {
  const Eigen::VectorXd distance = (one.z - other.z).cwiseQuotient(other.inverse.diagonal().cwiseSqrt());
  return distance.cwiseAbs().maxCoeff() > 1.0;
}

/// Whether no valley lies on the line between two ends.
bool one_peak(const LogDensity& log_density, const Peak& one, const Peak& other) {
  if (!apart(one, other)) return true;
  Eigen::MatrixXd between(one.z.size(), 3);
  for (int i = 0; i < 3; ++i) between.col(i) = one.z + 0.25 * (i + 1) * (other.z - one.z);
  return log_density(between).minCoeff() > std::min(one.value, other.value) - shallow;
}

/// What a search has told.
enum class SearchEnd { known, found, lost };

/// Peaks that searches have found so far.
class PeakList {
public:
  PeakList(const LogDensity& log_density, const LaplaceOptions& options)
      : log_density_([this, &log_density](const Eigen::MatrixXd& points) {
          likelihoods_ += points.cols();
          return log_density(points);
        }),
        options_(options) {}

  /// Lost: a search that did not converge, and ended at no known peak.
  SearchEnd search_from(const Eigen::VectorXd& start) {
    Peak end = climb(log_density_, start, options_, peaks_);
    if (!std::isfinite(end.value)) return SearchEnd::known;
    const auto same =
        std::find_if(peaks_.begin(), peaks_.end(), [&](const Peak& peak) { return one_peak(log_density_, end, peak); });
    if (same != peaks_.end()) {
      if (end.value > same->value && (end.converged || !same->converged)) *same = std::move(end);
      return SearchEnd::known;
    }
    const bool converged = end.converged, counts = peaks_.empty() || log_mass(end) > largest_mass() - negligible;
    if (counts) peaks_.push_back(std::move(end));
    if (!converged) return SearchEnd::lost;
    return counts ? SearchEnd::found : SearchEnd::known;
  }

  [[nodiscard]] Eigen::Index likelihoods() const { return likelihoods_; }
  [[nodiscard]] bool empty() const { return peaks_.empty(); }

  /// Those that count, the highest first.
  std::vector<Peak> finish() {
    const double least = largest_mass() - negligible;
    std::erase_if(peaks_, [&](const Peak& peak) { return log_mass(peak) < least; });
    std::ranges::stable_sort(peaks_, std::greater(), &Peak::value);
    return std::move(peaks_);
  }

private:
  [[nodiscard]] double largest_mass() const {
    double largest = -std::numeric_limits<double>::infinity();
    for (const auto& peak : peaks_) largest = std::max(largest, log_mass(peak));
    return largest;
  }

  Eigen::Index likelihoods_ = 0;
  LogDensity log_density_;
  const LaplaceOptions& options_;
  std::vector<Peak> peaks_;
};

}  // namespace

double unseen_share(int starts) { return starts > 0 ? 1.0 - std::pow(0.05, 1.0 / starts) : 1.0; }

PeakSearch find_peaks(const LogDensity& log_density, const JointPrior& prior, const LaplaceOptions& options) {
  if (options.start && options.start->size() != prior.size())
    throw InvalidInput("the start has " + std::to_string(options.start->size()) + " values",
                       "one for each of the " + std::to_string(prior.size()) + " parameters", "give one each");
  PeakList list(log_density, options);
  list.search_from(options.start ? prior.to_standard_normal(*options.start)
                                 : Eigen::VectorXd(Eigen::VectorXd::Zero(prior.size())));
  PeakSearch search;
  RandomStream random(options.seed, "laplace starts");
  const Eigen::Index before = list.likelihoods();
  const auto goes_on = [&](int searches, int settled) {
    return searches < options.random_starts ||
           (settled < settled_starts && list.likelihoods() - before < options.search_likelihoods);
  };
  for (int searches = 0, settled = 0; goes_on(searches, settled); ++searches) {
    const Eigen::VectorXd start = Eigen::VectorXd::NullaryExpr(prior.size(), [&] { return random.normal(); });
    const SearchEnd end = list.search_from(start);
    if (end != SearchEnd::lost) ++search.prior_starts;
    if (end == SearchEnd::known) ++settled;
    if (end == SearchEnd::found) settled = 0;
  }
  if (list.empty())
    throw InvalidInput("no start has a likelihood", "the search for the maximum has nowhere to begin",
                       "give a start where the model is possible, or more random starts");
  search.peaks = list.finish();
  return search;
}

}  // namespace kalfem
