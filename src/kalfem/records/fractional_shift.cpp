#include "kalfem/records/fractional_shift.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index shortest_bridge = 64;  ///< samples between the end of the signal and its periodic continuation

/// The signal with straight lines in place of missing samples; zero where none is there.
VectorXd without_gaps(const Eigen::Ref<const VectorXd>& signal) {
  VectorXd whole = signal;
  Index last = -1;
  for (Index k = 0; k < whole.size(); ++k) {
    if (!std::isfinite(signal[k])) continue;
    for (Index i = last + 1; i < k; ++i) {
      const double part = last < 0 ? 1.0 : static_cast<double>(i - last) / static_cast<double>(k - last);
      whole[i] = last < 0 ? signal[k] : (1.0 - part) * signal[last] + part * signal[k];
    }
    last = k;
  }
  const double end = last < 0 ? 0.0 : signal[last];
  whole.tail(whole.size() - last - 1).setConstant(end);
  return whole;
}

/// One period of a continuation: the signal, then a half cosine from its last value to its first.
std::vector<double> periodic(const VectorXd& signal) {
  Index length = 1;
  while (length < signal.size() + shortest_bridge) length *= 2;
  std::vector<double> period(static_cast<std::size_t>(length));
  VectorXd::Map(period.data(), signal.size()) = signal;
  const double from = signal[signal.size() - 1], to = signal[0];
  for (Index k = signal.size(); k < length; ++k) {
    const double part = static_cast<double>(k - signal.size() + 1) / static_cast<double>(length - signal.size() + 1);
    period[static_cast<std::size_t>(k)] = to + 0.5 * (from - to) * (1.0 + std::cos(std::numbers::pi * part));
  }
  return period;
}

}  // namespace

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
