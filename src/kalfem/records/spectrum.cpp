#include "kalfem/records/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The least 2^a 3^b 5^c that is not below n: transforms of other lengths take a time that grows with n times its
/// largest prime factor.
Index fast_length(Index n) {
  for (Index length = std::max<Index>(n, 1);; ++length) {
    Index rest = length;
    for (const Index factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return length;
  }
}

VectorXd hann(Index n) {
  const double last = 2.0 * std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n);
  return 0.5 - 0.5 * VectorXd::LinSpaced(n, 0.0, last).array().cos();
}

/// Spectrum of the Hann-windowed signal, followed by zeros up to a fast length.
Eigen::VectorXcd windowed_spectrum(const VectorXd& signal) {
  const Index n = signal.size();
  VectorXd windowed = VectorXd::Zero(fast_length(n));
  windowed.head(n) = signal.cwiseProduct(hann(n));
  Eigen::FFT<double> transform;
  Eigen::VectorXcd spectrum;
  transform.fwd(spectrum, windowed);
  return spectrum;
}

/// Sum of the squared spectrum over the lines in the band.
double power_in_band(const VectorXd& signal, double sample_rate, const FrequencyBand& band) {
  const Eigen::VectorXcd spectrum = windowed_spectrum(signal);
  const Index lines = spectrum.size();
  double power = 0.0;
  for (Index k = 0; k <= lines / 2; ++k) {
    const double f = static_cast<double>(k) * sample_rate / static_cast<double>(lines);
    if (f >= band.from && f <= band.to) power += std::norm(spectrum[k]);
  }
  return power;
}

}  // namespace

CumulativeSpectrum::CumulativeSpectrum(VectorXd signal, double sample_rate, int derivatives, Mean mean) {
  const auto present = (signal.array() == signal.array()).eval();
  const double middle =
      present.select(signal.array(), 0.0).sum() / static_cast<double>(std::max<Index>(1, present.count()));
  signal = present.select(signal.array() - middle, 0.0);
  if (mean == Mean::kept && derivatives == 0) of_mean_ = middle * middle;
  const Eigen::VectorXcd spectrum = windowed_spectrum(signal);
  const auto lines = static_cast<double>(spectrum.size());
  spacing_ = sample_rate / lines;
  const double scale = 2.0 / (lines * std::max(hann(signal.size()).squaredNorm(), 1e-300));
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

double nrmse_in_band(const VectorXd& estimate, const VectorXd& reference, double sample_rate,
                     const FrequencyBand& band) {
  const double size = power_in_band(reference, sample_rate, band);
  if (!(size > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(power_in_band(estimate - reference, sample_rate, band) / size);
}

}  // namespace kalfem
