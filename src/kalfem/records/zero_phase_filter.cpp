// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/zero_phase_filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "kalfem/records/signal_continuation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double margin_in_periods = 3.0;  ///< of the lowest limit

double gain_at(const ZeroPhaseFilter& filter, double frequency) {
  double gain = 1.0;
  if (filter.high_pass > 0.0)
    gain *= frequency > 0.0 ? 1.0 / std::sqrt(1.0 + std::pow(filter.high_pass / frequency, 2 * filter.order)) : 0.0;
  if (filter.low_pass > 0.0) gain /= std::sqrt(1.0 + std::pow(frequency / filter.low_pass, 2 * filter.order));
  return gain;
}

}  // namespace

VectorXd filtered(const Eigen::Ref<const VectorXd>& signal, double sample_rate, const ZeroPhaseFilter& filter) {
  const Index samples = signal.size();
  if (samples == 0) return signal;
  const double lowest = filter.high_pass > 0.0 ? filter.high_pass : filter.low_pass;
  if (!(lowest > 0.0)) return signal;
  const auto wanted = margin_in_periods * sample_rate / lowest;
  const auto margin = static_cast<Index>(std::min(wanted, static_cast<double>(samples - 1)));
  const std::vector<double> period = periodic(reflected(without_gaps(signal), margin));
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, period);
  const double spacing = sample_rate / static_cast<double>(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i)
    lines[i] *= gain_at(filter, spacing * static_cast<double>(std::min(i, lines.size() - i)));
  std::vector<double> passed;
  fft.inv(passed, lines);
  const VectorXd inside = VectorXd::Map(passed.data() + margin, samples);
  return signal.array().isFinite().select(inside, std::numeric_limits<double>::quiet_NaN());
}

}  // namespace kalfem
