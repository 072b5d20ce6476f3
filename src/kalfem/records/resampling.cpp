// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/resampling.hpp"

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/records/kaiser_kernel.hpp"
#include "kalfem/records/signal_continuation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double cut_off = 0.45;         ///< of the new rate: the middle between pass band and stop band
constexpr double half_length = 32.0;     ///< of the kernel, in new samples: a transition of 0.1 of the new rate
constexpr double most_missing = 0.02;    ///< of a new sample's weights
constexpr double same_rate = 1e-9;       ///< relative
constexpr double beyond_the_end = 1e-6;  ///< of a new interval

/// The impulse response from a table: straight lines between its entries are right to 3e-7 of the peak.
class Kernel {
public:
  Kernel() : entries_(static_cast<Index>(half_length) * per_sample + 2) {
    for (Index i = 0; i < entries_.size() - 2; ++i)
      entries_[i] = windowed_sinc(static_cast<double>(i) / static_cast<double>(per_sample), cut_off, half_length);
    entries_.tail(2).setZero();
  }

  double operator()(double time) const {
    const double place = std::abs(time) * static_cast<double>(per_sample);
    const auto entry = static_cast<Index>(place);
    if (entry + 1 >= entries_.size()) return 0.0;
    const double part = place - static_cast<double>(entry);
    return (1.0 - part) * entries_[entry] + part * entries_[entry + 1];
  }

private:
  static constexpr Index per_sample = 2048;
  VectorXd entries_;
};

/// A channel that can be asked for at any time within it.
class ContinuousChannel {
public:
  /// `ratio`: old samples in a new one.
  ContinuousChannel(const VectorXd& samples, double ratio, const Kernel& kernel)
      : ratio_(ratio),
        kernel_(kernel),
        margin_(static_cast<Index>(std::ceil(half_length * ratio)) + 1),
        signal_(reflected(without_gaps(samples), margin_)),
        missing_(samples.array().isFinite().select(VectorXd::Zero(samples.size()), 1.0)) {}

  /// At a time in old samples.
  [[nodiscard]] double operator()(double time) const {
    const double reach = half_length * ratio_;
    const auto from = static_cast<Index>(std::ceil(time - reach)), to = static_cast<Index>(std::floor(time + reach));
    double sum = 0.0, weights = 0.0, all = 0.0, missing = 0.0;
    for (Index k = from; k <= to; ++k) {
      const double weight = kernel_((static_cast<double>(k) - time) / ratio_);
      sum += weight * signal_[k + margin_];
      weights += weight;
      all += std::abs(weight);
      if (k >= 0 && k < missing_.size()) missing += std::abs(weight) * missing_[k];
    }
    return missing > most_missing * all ? std::numeric_limits<double>::quiet_NaN() : sum / weights;
  }

private:
  double ratio_;
  const Kernel& kernel_;
  Index margin_;
  VectorXd signal_, missing_;
};

}  // namespace

Record resampled(const Record& record, double sample_rate) {
  const double ratio = record.sample_rate / sample_rate;
  if (std::abs(ratio - 1.0) <= same_rate) return record;
  if (!(ratio > 1.0))
    throw InvalidInput("a sampling rate of " + shortest(sample_rate) + " Hz is asked for",
                       "the record has " + shortest(record.sample_rate) +
                           " Hz, and samples that were not measured say "
                           "nothing",
                       "ask for a lower rate, or leave it out");
  const auto samples =
      static_cast<Index>(std::floor(static_cast<double>(record.samples() - 1) / ratio + beyond_the_end)) + 1;
  Record lower{.sample_rate = sample_rate, .start = record.start, .channels = record.channels};
  lower.values.resize(record.values.rows(), samples);
  const Kernel kernel;
  for (Index j = 0; j < record.values.rows(); ++j) {
    const ContinuousChannel channel(record.values.row(j).transpose(), ratio, kernel);
    for (Index k = 0; k < samples; ++k) lower.values(j, k) = channel(static_cast<double>(k) * ratio);
  }
  return lower;
}

}  // namespace kalfem
