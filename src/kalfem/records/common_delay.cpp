// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/common_delay.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/resampling.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

constexpr Index fewest_samples = 16;
constexpr double least_overlap = 0.25;  ///< of the shorter record

/// Samples about their mean; zero where one is missing.
ArrayXd about_mean(const Record& record) {
  const ArrayXd values = record.values.row(0).transpose();
  const auto present = values.isFinite();
  const double mean = present.select(values, 0.0).sum() / std::max(1.0, static_cast<double>(present.count()));
  return present.select(values - mean, 0.0);
}

/// Cross-correlation sum_k a(k) b(k + lag) for any lag, from the cross spectrum.
class CrossCorrelation {
public:
  CrossCorrelation(const ArrayXd& a, const ArrayXd& b) {
    while (length_ < a.size() + b.size()) length_ *= 2;
    Eigen::FFT<double> fft;
    const auto lines_of = [&](const ArrayXd& signal) {
      std::vector<double> padded(static_cast<std::size_t>(length_), 0.0);
      std::ranges::copy(signal, padded.begin());
      std::vector<std::complex<double>> lines;
      fft.fwd(lines, padded);
      return lines;
    };
    const auto of_a = lines_of(a);
    lines_ = lines_of(b);
    for (std::size_t i = 0; i < lines_.size(); ++i) lines_[i] *= std::conj(of_a[i]);
    fft.inv(samples_, lines_);
  }

  [[nodiscard]] double at(Index lag) const { return samples_[static_cast<std::size_t>(lag < 0 ? lag + length_ : lag)]; }

  [[nodiscard]] double between(double lag) const {
    const double step = 2.0 * std::numbers::pi * lag / static_cast<double>(length_);
    double sum = lines_[0].real();
    for (Index i = 1; i < length_ / 2; ++i)
      sum += 2.0 * (lines_[static_cast<std::size_t>(i)] * std::polar(1.0, step * static_cast<double>(i))).real();
    return sum / static_cast<double>(length_);
  }

private:
  Index length_ = 2;
  std::vector<std::complex<double>> lines_;
  std::vector<double> samples_;
};

/// Sum of squares up to each sample.
ArrayXd energies(const ArrayXd& signal) {
  ArrayXd sums(signal.size() + 1);
  sums[0] = 0.0;
  for (Index k = 0; k < signal.size(); ++k) sums[k + 1] = sums[k] + signal[k] * signal[k];
  return sums;
}

/// Lag of the peak of a function between two lags, by golden sections.
template <class Function>
double peak_between(double from, double to, const Function& function) {
  constexpr double precision = 1e-5;  ///< samples
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  while (to - from > precision) {
    const double left = to - golden * (to - from), right = from + golden * (to - from);
    if (function(left) > function(right))
      to = right;
    else
      from = left;
  }
  return 0.5 * (from + to);
}

/// Lag within a sample of two signals that are aligned to the nearest one. Their ends fade, or what one of them has
/// beyond the other's would pull the peak.
double fractional_lag(const ArrayXd& a, const ArrayXd& b, bool opposite) {
  const ArrayXd part = ArrayXd::LinSpaced(a.size(), 0.0, 2.0 * std::numbers::pi);
  const ArrayXd fading = 0.5 - 0.5 * part.cos();
  const CrossCorrelation correlation(a * fading, b * fading);
  return peak_between(-1.0, 1.0, [&](double lag) { return (opposite ? -1.0 : 1.0) * correlation.between(lag); });
}

}  // namespace

CommonDelay common_delay(const Record& reference, const Record& late) {
  const double rate = std::min(reference.sample_rate, late.sample_rate);
  const ArrayXd a = about_mean(resampled(reference, rate)), b = about_mean(resampled(late, rate));
  if (std::min(a.size(), b.size()) < fewest_samples)
    throw InvalidInput("a delay is asked for between records of " + std::to_string(a.size()) + " and " +
                           std::to_string(b.size()) + " samples",
                       "fewer than " + std::to_string(fewest_samples) + " say nothing about it", "give longer records");
  const CrossCorrelation correlation(a, b);
  const ArrayXd of_a = energies(a), of_b = energies(b);
  const auto least = static_cast<Index>(least_overlap * static_cast<double>(std::min(a.size(), b.size())));
  Index best = 0;
  double highest = 0.0;
  for (Index lag = least - a.size(); lag <= b.size() - least; ++lag) {
    const Index from = std::max<Index>(0, -lag), to = std::min(a.size(), b.size() - lag);
    const double energy = (of_a[to] - of_a[from]) * (of_b[to + lag] - of_b[from + lag]);
    const double value = energy > 0.0 ? correlation.at(lag) / std::sqrt(energy) : 0.0;
    if (std::abs(value) <= std::abs(highest)) continue;
    highest = value;
    best = lag;
  }
  const Index from = std::max<Index>(0, -best), count = std::min(a.size(), b.size() - best) - from;
  const double fraction = fractional_lag(a.segment(from, count), b.segment(from + best, count), highest < 0.0);
  return {late.start - reference.start + (static_cast<double>(best) + fraction) / rate, highest};
}

}  // namespace kalfem
