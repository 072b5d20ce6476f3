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

/// Sum of the squared spectrum of the Hann-windowed signal, followed by zeros up to a fast length, over the lines in
/// the band.
double power_in_band(const VectorXd& signal, double sample_rate, const FrequencyBand& band) {
  const Index n = signal.size();
  const double last = 2.0 * std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n);
  const VectorXd phase = VectorXd::LinSpaced(n, 0.0, last);
  const Index lines = fast_length(n);
  VectorXd windowed = VectorXd::Zero(lines);
  windowed.head(n) = signal.array() * (0.5 - 0.5 * phase.array().cos());
  Eigen::FFT<double> transform;
  Eigen::VectorXcd spectrum;
  transform.fwd(spectrum, windowed);
  double power = 0.0;
  for (Index k = 0; k <= lines / 2; ++k) {
    const double f = static_cast<double>(k) * sample_rate / static_cast<double>(lines);
    if (f >= band.from && f <= band.to) power += std::norm(spectrum[k]);
  }
  return power;
}

}  // namespace

double nrmse_in_band(const VectorXd& estimate, const VectorXd& reference, double sample_rate,
                     const FrequencyBand& band) {
  const double size = power_in_band(reference, sample_rate, band);
  if (!(size > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(power_in_band(estimate - reference, sample_rate, band) / size);
}

}  // namespace kalfem
