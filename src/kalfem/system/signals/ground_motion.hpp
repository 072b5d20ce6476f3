// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/system/signal.hpp"

namespace kalfem {

/// What becomes of the part d0 + v0 t + a0 t^2 / 2 of a displacement that is integrated from an acceleration: an
/// accelerometer does not tell the displacement and velocity at its start, nor its own constant offset.
enum class Drift {
  remove,  ///< taken out
  keep     ///< left in, as from rest
};

/// The samples of an acceleration that are integrated.
struct IntegrationOptions {
  double start = 0.0;      ///< of the integration, where ground and displacement are at rest [s]
  double step = 1e-3;      ///< between two knots [s]
  Eigen::Index knots = 2;  ///< at least two
  Drift drift = Drift::keep;
};

/// A displacement r with r'' the given acceleration. Between two knots the acceleration is the polynomial of the fifth
/// degree through its values and first two derivatives at both, which is integrated exactly: a cubic spline with its
/// samples as knots is reproduced, smooth signals to (w step)^6 / 10^5.
///
/// Drift::remove takes out the parabola that fits the displacement best between the first and the last knot, by least
/// squares weighted with a Hann window: it hardly sees a motion that swings about its rest many times.
/// Outside the knots the integration goes on where the acceleration is known.
/// Throws InvalidInput where there is no signal, a number is unsuitable, or the acceleration is not known at a knot.
class GroundMotion final : public Signal {
public:
  GroundMotion(SignalPtr acceleration, const IntegrationOptions& options);

  [[nodiscard]] SignalSamples sample(double start, double step, Eigen::Index count) const override;
  [[nodiscard]] bool covers(double begin, double end) const override { return acceleration_->covers(begin, end); }
  [[nodiscard]] double determined_until() const override { return acceleration_->determined_until(); }
  /// What Drift::remove has taken out; nothing for Drift::keep.
  struct Removed {
    double velocity = 0.0;  ///< v0, at the first knot [m/s]
    double offset = 0.0;    ///< a0 [m/s^2]
    double part = 0.0;      ///< rms of the parabola against that of what is left, both under the window
  };
  [[nodiscard]] const Removed& removed() const { return removed_; }

private:
  /// Knots from `first` on: r, r' and [a, a', a''].
  struct Knots {
    Eigen::Index first = 0;
    Eigen::ArrayXd displacement, velocity;
    SignalSamples acceleration;

    [[nodiscard]] Eigen::Index last() const { return first + displacement.size() - 1; }
  };
  [[nodiscard]] double time_of(Eigen::Index knot) const {
    return options_.start + static_cast<double>(knot) * options_.step;
  }
  [[nodiscard]] SignalSamples acceleration_at(Eigen::Index first, Eigen::Index count) const;
  void integrate_forwards(Knots& knots, Eigen::Index from) const;
  void integrate_backwards(Knots& knots, Eigen::Index from) const;
  [[nodiscard]] Knots extended(Eigen::Index first, Eigen::Index last) const;
  [[nodiscard]] Eigen::Array<double, 1, 3> between(const Knots& knots, double position) const;
  void remove_drift();

  SignalPtr acceleration_;
  IntegrationOptions options_;
  Knots knots_;
  Removed removed_;
};

}  // namespace kalfem
