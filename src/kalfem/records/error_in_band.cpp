// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/error_in_band.hpp"

#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

/// Sum of the squared spectrum over the lines in the band.
double ErrorInBand::power_of(const VectorXd& signal) {
  const Eigen::VectorXcd& spectrum = transform_(signal);
  const Index lines = spectrum.size();
  double power = 0.0;
  for (Index k = 0; k <= lines / 2; ++k) {
    const double f = static_cast<double>(k) * sample_rate_ / static_cast<double>(lines);
    if (f >= band_.from && f <= band_.to) power += std::norm(spectrum[k]);
  }
  return power;
}

double ErrorInBand::operator()(const VectorXd& estimate, const VectorXd& reference) {
  const double size = power_of(reference);
  if (!(size > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(power_of(estimate - reference) / size);
}

double nrmse_in_band(const VectorXd& estimate, const VectorXd& reference, double sample_rate,
                     const FrequencyBand& band) {
  return ErrorInBand(reference.size(), sample_rate, band)(estimate, reference);
}

}  // namespace kalfem
