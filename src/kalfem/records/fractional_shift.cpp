// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/fractional_shift.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "kalfem/records/signal_continuation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd shifted(const Eigen::Ref<const VectorXd>& signal, double lead) {
  const Index samples = signal.size();
  if (samples == 0) return signal;
  const std::vector<double> period = periodic(without_gaps(signal));
  const auto length = static_cast<double>(period.size());
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, period);
  const std::size_t half = lines.size() / 2;
  for (std::size_t i = 1; i < half; ++i) {
    lines[i] *= std::polar(1.0, 2.0 * std::numbers::pi * static_cast<double>(i) * lead / length);
    lines[lines.size() - i] = std::conj(lines[i]);
  }
  lines[half] *= std::cos(std::numbers::pi * lead);
  std::vector<double> moved;
  fft.inv(moved, lines);
  VectorXd result = VectorXd::Constant(samples, std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < samples; ++k) {
    const auto nearest = static_cast<Index>(std::llround(static_cast<double>(k) + lead));
    if (nearest >= 0 && nearest < samples && std::isfinite(signal[nearest]))
      result[k] = moved[static_cast<std::size_t>(k)];
  }
  return result;
}

}  // namespace kalfem
