// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/signal_continuation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index shortest_bridge = 64;  ///< samples between the end of the signal and its periodic continuation

}  // namespace

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

VectorXd reflected(const VectorXd& signal, Index margin) {
  const Index last = signal.size() - 1;
  VectorXd longer(signal.size() + 2 * margin);
  longer.segment(margin, signal.size()) = signal;
  for (Index k = 1; k <= margin; ++k) {
    const Index inside = std::min(k, last);
    longer[margin - k] = 2.0 * signal[0] - signal[inside];
    longer[margin + last + k] = 2.0 * signal[last] - signal[last - inside];
  }
  return longer;
}

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

}  // namespace kalfem
