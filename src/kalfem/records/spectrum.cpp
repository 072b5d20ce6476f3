// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/records/windowed_transform.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

CumulativeSpectrum::CumulativeSpectrum(VectorXd signal, double sample_rate, int derivatives, Mean mean) {
  const auto present = (signal.array() == signal.array()).eval();
  const double middle =
      present.select(signal.array(), 0.0).sum() / static_cast<double>(std::max<Index>(1, present.count()));
  signal = present.select(signal.array() - middle, 0.0);
  if (mean == Mean::kept && derivatives == 0) of_mean_ = middle * middle;
  WindowedTransform transform(signal.size());
  const Eigen::VectorXcd& spectrum = transform(signal);
  const auto lines = static_cast<double>(spectrum.size());
  spacing_ = sample_rate / lines;
  const double scale = 2.0 / (lines * std::max(hann_window(signal.size()).squaredNorm(), 1e-300));
  up_to_.resize(spectrum.size() / 2 + 1);
  double sum = 0.0;
  for (Index k = 0; k < up_to_.size(); ++k) {
    const double omega = 2.0 * std::numbers::pi * static_cast<double>(k) * spacing_;
    sum += scale * std::norm(spectrum[k]) * std::pow(omega, 2 * derivatives);
    up_to_[k] = sum;
  }
}

double CumulativeSpectrum::mean_square_below(double frequency) const {
  const auto line = static_cast<Index>(std::min(frequency / spacing_, static_cast<double>(up_to_.size() - 1)));
  return of_mean_ + up_to_[line];
}

namespace {

/// The signal about its mean; what is missing becomes 0.
VectorXd centred(const VectorXd& signal) {
  const auto present = signal.array().isFinite().eval();
  const auto count = static_cast<double>(std::max<Index>(1, present.count()));
  const double mean = present.select(signal.array(), 0.0).sum() / count;
  return present.select(signal.array() - mean, 0.0);
}

/// One-sided power of each line, the mean over pieces that overlap by half. Their sum is the mean square.
struct PowerLines {
  double spacing = 0.0;  ///< [Hz]
  VectorXd power;
};

PowerLines welch(const VectorXd& signal, double sample_rate, Index piece) {
  PowerLines lines;
  WindowedTransform transform(piece);
  Index pieces = 0;
  for (Index first = 0; first + piece <= signal.size(); first += std::max<Index>(1, piece / 2)) {
    const Eigen::VectorXcd& spectrum = transform(signal.segment(first, piece));
    const Index count = spectrum.size() / 2 + 1;
    if (pieces++ == 0) {
      lines.power = VectorXd::Zero(count);
      lines.spacing = sample_rate / static_cast<double>(spectrum.size());
    }
    lines.power += 2.0 / static_cast<double>(spectrum.size()) * spectrum.head(count).cwiseAbs2();
  }
  lines.power /= static_cast<double>(pieces) * std::max(hann_window(piece).squaredNorm(), 1e-300);
  return lines;
}

/// The line is the highest of those within three, and four times as high as the median of those within twenty.
bool is_peak(const VectorXd& power, Index line) {
  const auto around = [&](Index reach) -> VectorXd {
    const Index first = std::max<Index>(1, line - reach), last = std::min(power.size() - 1, line + reach);
    return power.segment(first, last - first + 1);
  };
  if (power[line] < around(3).maxCoeff()) return false;
  VectorXd near = around(20);
  std::nth_element(near.begin(), near.begin() + near.size() / 2, near.end());
  return power[line] > 4.0 * near[near.size() / 2];
}

/// Power in the band, and the mean frequency of its lines that have a tenth of the highest one's power: a harmonic in
/// the same band moves the frequency no more.
SpectralPeak refined(const PowerLines& fine, double frequency, double half_width) {
  const auto last = fine.power.size() - 1;
  const auto from = std::clamp<Index>(static_cast<Index>(std::ceil((frequency - half_width) / fine.spacing)), 1, last),
             to =
                 std::clamp<Index>(static_cast<Index>(std::floor((frequency + half_width) / fine.spacing)), from, last);
  const auto band = fine.power.segment(from, to - from + 1);
  const double least = 0.1 * band.maxCoeff();
  double strong = 0.0, moment = 0.0;
  for (Index k = from; k <= to; ++k) {
    if (fine.power[k] < least) continue;
    strong += fine.power[k];
    moment += fine.power[k] * static_cast<double>(k) * fine.spacing;
  }
  return {strong > 0.0 ? moment / strong : frequency, band.sum()};
}

}  // namespace

std::vector<SpectralPeak> spectral_peaks(VectorXd signal, double sample_rate, std::size_t most) {
  constexpr Index shortest = 16, longest = Index{1} << 19;
  constexpr double least_share = 0.02;
  signal = centred(signal);
  const double mean_square = signal.squaredNorm() / static_cast<double>(std::max<Index>(1, signal.size()));
  if (signal.size() < shortest || !(mean_square > 0.0)) return {};
  const auto coarse =
      welch(signal, sample_rate, std::clamp(signal.size() / 8, std::min<Index>(64, signal.size()), longest));
  const auto fine = welch(signal, sample_rate, std::min(signal.size(), longest));
  std::vector<SpectralPeak> peaks;
  for (Index k = 1; k + 1 < coarse.power.size(); ++k) {
    if (!is_peak(coarse.power, k)) continue;
    auto peak = refined(fine, static_cast<double>(k) * coarse.spacing, 2.0 * coarse.spacing);
    peak.share = std::min(1.0, peak.share / mean_square);
    if (peak.share >= least_share) peaks.push_back(peak);
  }
  std::ranges::sort(peaks, std::greater<>(), &SpectralPeak::share);
  if (peaks.size() > most) peaks.resize(most);
  return peaks;
}

}  // namespace kalfem
