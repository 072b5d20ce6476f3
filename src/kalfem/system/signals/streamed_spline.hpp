// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The cubic spline through equidistant samples that come one by one. It stands at a sample, the first one at the
/// start, and moves to the next once later samples are there:
///
///     spline.add(value);
///     if (spline.ahead() > delay) samples = spline.move(parts);
///
/// The curvature at a sample, once computed, stays. It follows from the one before and from the samples ahead, with a
/// not-a-knot condition at the newest. A sample reaches back by a factor of 2 - sqrt(3) = 0.27 an interval: with n
/// samples ahead, curvatures differ from those of the whole record's spline by 0.27^n of themselves, 3e-5 for 8. Values
/// are those of the samples always, so the mean of the rate over an interval is exact.
class StreamedSpline {
public:
  StreamedSpline() : StreamedSpline(0.0, 1.0) {}
  /// `first`: value of the sample at which it stands.
  StreamedSpline(double first, double sample_rate) : values_{first}, sample_rate_(sample_rate) {}

  void add(double value) { values_.push_back(value); }
  /// Samples after the one at which it stands.
  [[nodiscard]] Eigen::Index ahead() const { return static_cast<Eigen::Index>(values_.size()) - 1; }
  /// Value, rate and acceleration where it stands before the first move; of a single sample rate and acceleration are
  /// zero.
  [[nodiscard]] SignalSamples first();
  /// Moves to the next sample, one of those ahead. Returns value, rate and acceleration from the sample before to this
  /// one at equal distances, (parts + 1) x 3.
  SignalSamples move(Eigen::Index parts);

  /// All of it, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.values_);
    archive(self.sample_rate_);
    archive(self.curvature_);
    archive(self.before_);
  }

private:
  /// Second derivatives at the present sample and at those ahead, per sampling interval squared.
  [[nodiscard]] Eigen::VectorXd curvature() const;

  std::deque<double> values_;                 ///< of the present sample, and of those ahead
  double sample_rate_;                        ///< [Hz]
  std::optional<double> curvature_, before_;  ///< at the present sample and at the one before it, once known
};

}  // namespace kalfem
