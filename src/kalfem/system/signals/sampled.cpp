// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/sampled.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {
namespace {

double second_difference(const Eigen::VectorXd& y, Eigen::Index i) { return y(i - 1) - 2.0 * y(i) + y(i + 1); }

/// Thomas elimination of x_{i-1} + 4 x_i + x_{i+1} = right_i over first..last, with x known just outside.
void solve_between(Eigen::VectorXd& x, const Eigen::VectorXd& y, Eigen::Index first, Eigen::Index last) {
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index i = first; i <= last; ++i) {
    const double pivot = 4.0 - weight(i - 1);
    weight(i) = 1.0 / pivot;
    x(i) = (6.0 * second_difference(y, i) - x(i - 1)) / pivot;
  }
  for (Eigen::Index i = last; i >= first; --i) x(i) -= weight(i) * x(i + 1);
}

/// Second derivatives M of the cubic not-a-knot spline through equidistant samples y, the interval taken as 1:
///     M_{i-1} + 4 M_i + M_{i+1} = 6 (y_{i-1} - 2 y_i + y_{i+1}),     M_0 = 2 M_1 - M_2,   M_{N-1} = 2 M_{N-2} -
///     M_{N-3}.
/// The end conditions turn the first and last equation into M_1 = y_0 - 2 y_1 + y_2 and its mirror image, so what is
/// left is a tridiagonal system between known values. Fewer than four samples: the parabola or line through them.
/// Source: de Boor, A Practical Guide to Splines (1978), chapter IV.
Eigen::VectorXd not_a_knot_curvature(const Eigen::VectorXd& y) {
  const Eigen::Index n = y.size();
  Eigen::VectorXd M = Eigen::VectorXd::Zero(n);
  if (n < 3) return M;
  if (n == 3) return Eigen::VectorXd::Constant(n, second_difference(y, 1));
  M(1) = second_difference(y, 1);
  M(n - 2) = second_difference(y, n - 2);
  solve_between(M, y, 2, n - 3);
  M(0) = 2.0 * M(1) - M(2);
  M(n - 1) = 2.0 * M(n - 2) - M(n - 3);
  return M;
}

/// Value, slope and curvature of the cubic between two samples (values y, second derivatives M) at x in [0, 1].
std::array<double, 3> spline_segment(double y0, double y1, double M0, double M1, double x) {
  const double r = 1.0 - x;
  return {r * y0 + x * y1 + (M0 * (r * r * r - r) + M1 * (x * x * x - x)) / 6.0,
          y1 - y0 + (M0 * (1.0 - 3.0 * r * r) + M1 * (3.0 * x * x - 1.0)) / 6.0, r * M0 + x * M1};
}

constexpr double edge = 1e-6;  // of a sampling interval: instants that rounding moved over an end or a sample

// Between samples the record is a cubic spline with the not-a-knot condition (or straight): its second derivative is
// continuous, as an input's must be. Curvatures at the samples are solved for once; a value costs one segment.
class Sampled final : public Signal {
public:
  Sampled(Eigen::VectorXd values, const SampledOptions& options)
      : options_(options), values_(std::move(values)), curvature_(Eigen::VectorXd::Zero(values_.size())) {
    if (options_.interpolation == Interpolation::cubic) curvature_ = not_a_knot_curvature(values_);
  }

  bool covers(double begin, double end) const override {
    return options_.beyond == BeyondRecord::hold || (position(begin) >= -edge && position(end) <= last() + edge);
  }

  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    check_sampling(start, step, count);
    if (count > 0) require_covered(start, start + static_cast<double>(count - 1) * step);
    SignalSamples samples(count, 3);
    for (Eigen::Index k = 0; k < count; ++k) samples.row(k) = at(position(start + static_cast<double>(k) * step));
    return samples;
  }

private:
  double last() const { return static_cast<double>(values_.size() - 1); }
  double position(double time) const { return (time - options_.start) * options_.sample_rate; }

  void require_covered(double begin, double end) const {
    if (covers(begin, end)) return;
    throw InvalidInput("a record from " + to_string(options_.start) + " s to " +
                           to_string(options_.start + last() / options_.sample_rate) + " s is requested from " +
                           to_string(begin) + " s to " + to_string(end) + " s",
                       "it is unknown outside its samples",
                       "shorten the analysis, supply a longer record, or extend the record with its end values");
  }

  /// Value and derivatives at a position counted in samples.
  Eigen::Array<double, 1, 3> at(double position) const {
    if (position < -edge) return {values_(0), 0.0, 0.0};
    if (position > last() + edge) return {values_(values_.size() - 1), 0.0, 0.0};
    const auto i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(position + edge), 0, values_.size() - 2);
    const auto [value, slope, curvature] =
        spline_segment(values_(i), values_(i + 1), curvature_(i), curvature_(i + 1), position - static_cast<double>(i));
    const double rate = options_.sample_rate;
    return {value, slope * rate, curvature * rate * rate};
  }

  SampledOptions options_;
  Eigen::VectorXd values_;
  Eigen::VectorXd curvature_;  ///< second derivatives at the samples, per sampling interval squared
};

}  // namespace

IssueList validate(const SampledOptions& options) {
  IssueList issues;
  require_positive(issues, "sampled signal: sample_rate [Hz]", options.sample_rate);
  require_finite(issues, "sampled signal: start [s]", options.start);
  return issues;
}

SignalPtr make_sampled(Eigen::VectorXd values, const SampledOptions& options) {
  IssueList issues = validate(options);
  if (values.size() < 2)
    issues.add({}, "sampled signal: " + std::to_string(values.size()) + " samples",
               "interpolation needs at least two samples");
  for (Eigen::Index k = 0; k < values.size(); ++k)
    if (!std::isfinite(values(k))) {
      issues.add({}, "sampled signal: sample " + std::to_string(k + 1) + " is " + to_string(values(k)),
                 "every sample must be finite", "repair or cut the record");
      break;
    }
  issues.raise();
  return std::make_shared<Sampled>(std::move(values), options);
}

}  // namespace kalfem
