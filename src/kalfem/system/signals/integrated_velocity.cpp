// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/integrated_velocity.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index knots_per_sample = 4;  ///< a spline through oversampled values has its own knots there

// Between two knots the velocity is a cubic, given by its values and second derivatives at both; r at a knot is the sum
// of the integrals before it.
class IntegratedVelocity final : public Signal {
public:
  IntegratedVelocity(SignalPtr velocity, const VelocitySamples& samples)
      : velocity_(std::move(velocity)),
        start_(samples.start),
        step_(1.0 / (samples.sample_rate * static_cast<double>(knots_per_sample))) {
    const Index knots = knots_per_sample * (samples.count - 1) + 1;
    given_ = velocity_->sample(start_, step_, knots);
    displacement_ = ArrayXd::Zero(knots);
    for (Index k = 0; k + 1 < knots; ++k) displacement_[k + 1] = displacement_[k] + gained(k, 1.0);
    remove_drift();
  }

  [[nodiscard]] bool covers(double begin, double end) const override { return velocity_->covers(begin, end); }
  [[nodiscard]] double determined_until() const override { return velocity_->determined_until(); }

  [[nodiscard]] SignalSamples sample(double start, double step, Index count) const override {
    SignalSamples samples = velocity_->sample(start, step, count);
    samples.col(2) = samples.col(1).eval();
    samples.col(1) = samples.col(0).eval() - offset_;
    for (Index k = 0; k < count; ++k) samples(k, 0) = displacement_at(start + static_cast<double>(k) * step);
    return samples;
  }

private:
  /// Displacement gained from knot k to a part x of its step.
  [[nodiscard]] double gained(Index k, double x) const {
    const double square = step_ * step_;
    return step_ * spline_integral(given_(k, 0), given_(k + 1, 0), square * given_(k, 2), square * given_(k + 1, 2), x);
  }

  [[nodiscard]] double displacement_at(double time) const {
    const double position = (time - start_) / step_;
    const Index k = std::clamp<Index>(static_cast<Index>(position), 0, displacement_.size() - 2);
    return displacement_[k] + gained(k, position - static_cast<double>(k));
  }

  /// Takes c0 + c1 x off the displacement, x from -1 to 1 over the knots, and its slope off the velocity.
  void remove_drift() {
    const Index n = displacement_.size();
    const auto last = static_cast<double>(n - 1);
    const ArrayXd x = ArrayXd::LinSpaced(n, -1.0, 1.0);
    const ArrayXd window = (0.5 * std::numbers::pi * x * last / (last + 1.0)).cos().square();
    const double mean = (window * displacement_).sum() / window.sum();  // x has no mean under the window
    const double slope = (window * x * displacement_).sum() / (window * x.square()).sum();
    displacement_ -= mean + slope * x;
    offset_ = 2.0 * slope / (last * step_);
    given_.col(0) -= offset_;
  }

  SignalPtr velocity_;
  double start_, step_;   ///< first knot, and between two knots [s]
  double offset_ = 0.0;   ///< of the velocity [m/s]
  SignalSamples given_;   ///< velocity without its offset, and its derivatives, at the knots
  ArrayXd displacement_;  ///< at the knots
};

}  // namespace

SignalPtr integrated_velocity(SignalPtr velocity, const VelocitySamples& samples) {
  return std::make_shared<const IntegratedVelocity>(std::move(velocity), samples);
}

}  // namespace kalfem
