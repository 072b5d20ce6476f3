// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/streamed_spline.hpp"

#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd StreamedSpline::curvature() const {
  VectorXd values(std::ssize(values_));
  std::ranges::copy(values_, values.begin());
  if (!curvature_) return not_a_knot_curvature(values);
  if (values.size() > 2 || !before_) return continued_curvature(values, *curvature_);
  return Eigen::Vector2d(*curvature_, 2.0 * *curvature_ - *before_);  // the end of all samples
}

SignalSamples StreamedSpline::first() {
  SignalSamples samples = SignalSamples::Zero(1, 3);
  samples(0, 0) = values_.front();
  if (ahead() == 0) return samples;
  const VectorXd M = curvature();
  const auto [value, slope, curvature] = spline_segment(values_[0], values_[1], M[0], M[1], 0.0);
  samples.row(0) << value, slope * sample_rate_, curvature * sample_rate_ * sample_rate_;
  return samples;
}

SignalSamples StreamedSpline::move(Index parts) {
  const VectorXd M = curvature();
  SignalSamples samples(parts + 1, 3);
  for (Index i = 0; i <= parts; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(parts);
    const auto [value, slope, curvature] = spline_segment(values_[0], values_[1], M[0], M[1], x);
    samples.row(i) << value, slope * sample_rate_, curvature * sample_rate_ * sample_rate_;
  }
  values_.pop_front();
  before_ = M[0];
  curvature_ = M[1];
  return samples;
}

}  // namespace kalfem
