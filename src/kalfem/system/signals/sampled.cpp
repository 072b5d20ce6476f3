// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/sampled.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "kalfem/base/units.hpp"
#include "kalfem/records/oversampling.hpp"
#include "kalfem/system/option_checks.hpp"
#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {
namespace {

std::string in_seconds(double time) { return shortest(std::round(time * 1e6) / 1e6) + " s"; }

/// A duration, short ones in milliseconds.
std::string in_words(double duration) {
  return duration < 1.0 ? shortest(std::round(duration * 1e6) / 1e3) + " ms" : in_seconds(duration);
}

constexpr Eigen::Index oversampling = 4;  ///< samples in the place of one
/// Part of its rms that a spline may take from a signal: parameters come from good records to a part in a thousand, and
/// what is taken from an excitation is missing in them.
constexpr double largest_spline_error = 1e-4;

constexpr double edge = 1e-6;  // of a sampling interval: instants that rounding moved over an end or a sample

// Between samples the record is a cubic spline with the not-a-knot condition (or straight): its second derivative is
// continuous, as an input's must be. Curvatures at the samples are solved for once; a value costs one segment.
class Sampled final : public Signal {
public:
  Sampled(Eigen::VectorXd values, const SampledOptions& options,
          double determined_until = std::numeric_limits<double>::infinity())
      : options_(options),
        values_(std::move(values)),
        curvature_(Eigen::VectorXd::Zero(values_.size())),
        determined_until_(determined_until) {
    if (options_.interpolation == Interpolation::cubic) curvature_ = not_a_knot_curvature(values_);
  }

  bool covers(double begin, double end) const override {
    return options_.beyond == BeyondRecord::hold || (position(begin) >= -edge && position(end) <= last() + edge);
  }

  double determined_until() const override { return determined_until_; }

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
    const double first_time = options_.start, last_time = first_time + last() / options_.sample_rate;
    const bool early = position(begin) < -edge;
    throw InvalidInput(
        early ? "the input begins at " + in_seconds(first_time) + ", " + in_words(first_time - begin) + " after " +
                    in_seconds(begin) + ", where it is needed"
              : "the input ends at " + in_seconds(last_time) + ", " + in_words(end - last_time) + " before " +
                    in_seconds(end) + ", where it is needed",
        "it is unknown outside its samples",
        "use the part that the input covers, or supply a longer input; if both were recorded together, their clocks "
        "differ: correct the sampling rate of one");
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
  double determined_until_;    ///< [s]
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
  if (options.interpolation == Interpolation::linear || !(spline_error(values) > largest_spline_error))
    return std::make_shared<Sampled>(std::move(values), options);
  SampledOptions finer = options;
  finer.sample_rate *= static_cast<double>(oversampling);
  const auto determined = static_cast<double>(values.size() - 1 - undetermined_samples(values));
  return std::make_shared<Sampled>(oversampled(values, oversampling), finer,
                                   options.start + determined / options.sample_rate);
}

}  // namespace kalfem
