// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/ground_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

using Eigen::Index;

constexpr double edge = 1e-6;       ///< of a step: instants that rounding moved over an end
constexpr double most_knots = 2e8;  ///< beside those that were given

/// The acceleration over one step, sum_k c_k s^k with s in [0, 1], and its integrals.
class Segment {
public:
  /// `begin`, `end`: value and first two derivatives at both ends.
  Segment(const Eigen::Array<double, 1, 3>& begin, const Eigen::Array<double, 1, 3>& end, double h) : h_(h) {
    c_ = {begin[0], h * begin[1], 0.5 * h * h * begin[2], 0.0, 0.0, 0.0};
    const double value = end[0] - c_[0] - c_[1] - c_[2], slope = h * end[1] - c_[1] - 2.0 * c_[2],
                 curvature = h * h * end[2] - 2.0 * c_[2];
    c_[3] = 10.0 * value - 4.0 * slope + 0.5 * curvature;
    c_[4] = -15.0 * value + 7.0 * slope - curvature;
    c_[5] = 6.0 * value - 3.0 * slope + 0.5 * curvature;
  }

  /// Displacement from the step's begin without its velocity's share, velocity gained, and acceleration at s.
  [[nodiscard]] Eigen::Array<double, 1, 3> at(double s) const {
    double displacement = 0.0, velocity = 0.0, acceleration = 0.0;
    for (std::size_t k = c_.size(); k-- > 0;) {
      const auto n = static_cast<double>(k);
      displacement = displacement * s + c_[k] / ((n + 1.0) * (n + 2.0));
      velocity = velocity * s + c_[k] / (n + 1.0);
      acceleration = acceleration * s + c_[k];
    }
    return {h_ * h_ * s * s * displacement, h_ * s * velocity, acceleration};
  }

private:
  double h_;
  std::array<double, 6> c_{};
};

void check(const SignalPtr& acceleration, const IntegrationOptions& options) {
  IssueList issues;
  if (!acceleration) issues.add({}, "a signal is missing (null pointer)", "integration needs an acceleration");
  require_finite(issues, "start of the integration [s]", options.start);
  require_positive(issues, "step of the integration [s]", options.step);
  if (options.knots < 2)
    issues.add({}, std::to_string(options.knots) + " samples of an acceleration", "integration needs at least two");
  issues.raise();
}

}  // namespace

GroundMotion::GroundMotion(SignalPtr acceleration, const IntegrationOptions& options)
    : acceleration_(std::move(acceleration)), options_(options) {
  check(acceleration_, options_);
  knots_.acceleration = acceleration_at(0, options_.knots);
  knots_.displacement = knots_.velocity = Eigen::ArrayXd::Zero(options_.knots);
  integrate_forwards(knots_, 0);
  if (options_.drift == Drift::remove) remove_drift();
}

SignalSamples GroundMotion::acceleration_at(Index first, Index count) const {
  SignalSamples samples = acceleration_->sample(time_of(first), options_.step, count);
  samples.col(0) -= removed_.offset;
  return samples;
}

/// r and r' of the knots behind `from`, which has them.
void GroundMotion::integrate_forwards(Knots& knots, Index from) const {
  for (Index k = from; k + 1 < knots.displacement.size(); ++k) {
    const auto gained = Segment(knots.acceleration.row(k), knots.acceleration.row(k + 1), options_.step).at(1.0);
    knots.displacement[k + 1] = knots.displacement[k] + options_.step * knots.velocity[k] + gained[0];
    knots.velocity[k + 1] = knots.velocity[k] + gained[1];
  }
}

/// r and r' of the knots before `from`, which has them.
void GroundMotion::integrate_backwards(Knots& knots, Index from) const {
  for (Index k = from; k-- > 0;) {
    const auto gained = Segment(knots.acceleration.row(k), knots.acceleration.row(k + 1), options_.step).at(1.0);
    knots.velocity[k] = knots.velocity[k + 1] - gained[1];
    knots.displacement[k] = knots.displacement[k + 1] - options_.step * knots.velocity[k] - gained[0];
  }
}

/// The knots with more of them before and behind.
GroundMotion::Knots GroundMotion::extended(Index first, Index last) const {
  const Index before = knots_.first - first, own = knots_.displacement.size(), behind = last - knots_.last();
  if (static_cast<double>(before) + static_cast<double>(behind) > most_knots)
    throw InvalidInput("the motion of a ground is requested long before or after the time span of the case",
                       "it would have to be integrated up to there", "check the times of the record and of delays");
  Knots all{first, Eigen::ArrayXd::Zero(before + own + behind), Eigen::ArrayXd::Zero(before + own + behind),
            SignalSamples(before + own + behind, 3)};
  all.displacement.segment(before, own) = knots_.displacement;
  all.velocity.segment(before, own) = knots_.velocity;
  all.acceleration << acceleration_at(first, before), knots_.acceleration, acceleration_at(knots_.last() + 1, behind);
  integrate_backwards(all, before);
  integrate_forwards(all, before + own - 1);
  return all;
}

// Times outside the knots extend them first, as far as the acceleration is known; then each instant lies in one step.
SignalSamples GroundMotion::sample(double start, double step, Index count) const {
  check_sampling(start, step, count);
  SignalSamples samples(count, 3);
  if (count == 0) return samples;
  const auto position = [&](double time) { return (time - options_.start) / options_.step; };
  const double low = position(start), high = position(start + static_cast<double>(count - 1) * step);
  const bool starts_before =
      low<static_cast<double>(knots_.first) - edge, ends_behind = high> static_cast<double>(knots_.last()) + edge;
  Knots more;
  if (starts_before || ends_behind) {
    if (high - low > 1e15 || std::abs(low) > 1e15) throw InvalidInput("a time is far from the record", "", "");
    more = extended(starts_before ? static_cast<Index>(std::floor(low)) : knots_.first,
                    ends_behind ? static_cast<Index>(std::ceil(high)) : knots_.last());
  }
  const Knots& knots = starts_before || ends_behind ? more : knots_;
  for (Index k = 0; k < count; ++k)
    samples.row(k) = between(knots, position(start + static_cast<double>(k) * step) - static_cast<double>(knots.first));
  return samples;
}

/// At so many steps from the first of these knots.
Eigen::Array<double, 1, 3> GroundMotion::between(const Knots& knots, double position) const {
  const Index k = std::clamp<Index>(static_cast<Index>(position), 0, knots.displacement.size() - 2);
  const double s = position - static_cast<double>(k);
  Eigen::Array<double, 1, 3> motion =
      Segment(knots.acceleration.row(k), knots.acceleration.row(k + 1), options_.step).at(s);
  motion[0] += knots.displacement[k] + s * options_.step * knots.velocity[k];
  motion[1] += knots.velocity[k];
  return motion;
}

// Weighted least squares for the parabola in x from -1 to 1, where its three functions are of one size. Its second
// derivative comes off the acceleration as well, so that displacement, velocity and acceleration stay consistent.
void GroundMotion::remove_drift() {
  const Index n = knots_.displacement.size();
  const auto last = static_cast<double>(n - 1);
  // p = c0 + c1 x + c2 x^2 with x from -1 to 1 over the knots
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(n, -1.0, 1.0);
  const Eigen::ArrayXd window = (0.5 * std::numbers::pi * x * last / (last + 1.0)).cos().square();
  Eigen::MatrixX3d basis(n, 3);
  basis << Eigen::VectorXd::Ones(n), x.matrix(), x.square().matrix();
  const Eigen::MatrixX3d weighted = window.matrix().asDiagonal() * basis;
  const Eigen::Vector3d c =
      Eigen::Matrix3d(weighted.transpose() * basis).ldlt().solve(weighted.transpose() * knots_.displacement.matrix());
  const Eigen::ArrayXd parabola = basis * c;
  const double rate = 2.0 / (last * options_.step);  // x per second
  removed_.velocity = rate * (c[1] - 2.0 * c[2]);
  removed_.offset = 2.0 * c[2] * rate * rate;
  knots_.displacement -= parabola;
  knots_.velocity -= rate * (c[1] + 2.0 * c[2] * x);
  knots_.acceleration.col(0) -= removed_.offset;
  removed_.part =
      std::sqrt((window * parabola.square()).sum() / std::max(1e-300, (window * knots_.displacement.square()).sum()));
}

}  // namespace kalfem
