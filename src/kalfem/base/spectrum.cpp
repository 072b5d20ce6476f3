#include "kalfem/base/spectrum.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Sum of the squared spectrum of the Hann-windowed signal over the bins in the band.
double power_in_band(const VectorXd& signal, double sample_rate, const FrequencyBand& band) {
  const Index n = signal.size();
  const double last = 2.0 * std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n);
  const VectorXd phase = VectorXd::LinSpaced(n, 0.0, last);
  const VectorXd windowed = signal.array() * (0.5 - 0.5 * phase.array().cos());
  Eigen::FFT<double> transform;
  Eigen::VectorXcd spectrum;
  transform.fwd(spectrum, windowed);
  double power = 0.0;
  for (Index k = 0; k <= n / 2; ++k)
    if (const double f = static_cast<double>(k) * sample_rate / static_cast<double>(n); f >= band.from && f <= band.to)
      power += std::norm(spectrum[k]);
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
