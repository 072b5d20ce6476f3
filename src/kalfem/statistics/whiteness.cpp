// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/whiteness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;

double Autocorrelation::widening() const {
  const double rho = std::clamp(value, 0.0, 0.9999);
  return std::sqrt((1.0 + rho) / (1.0 - rho));
}

Autocorrelation autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& sequence) {
  double product = 0.0, before = 0.0, after = 0.0;
  Autocorrelation found;
  for (Index k = 1; k < sequence.size(); ++k) {
    const double a = sequence[k - 1], b = sequence[k];
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    product += a * b;
    before += a * a;
    after += b * b;
    ++found.pairs;
  }
  if (found.pairs < 2) return {0.0, std::numeric_limits<double>::infinity(), found.pairs};
  const double scale = std::sqrt(before) * std::sqrt(after);
  found.value = scale > 0.0 ? product / scale : 0.0;
  found.band = 1.96 / std::sqrt(static_cast<double>(found.pairs));
  return found;
}

}  // namespace kalfem
