// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// How much of a sequence repeats in its next sample.
struct Autocorrelation {
  double value = 0.0;      ///< rho(1) = sum e_k e_{k+1} / sqrt(sum e_k^2 sum e_{k+1}^2) over pairs that are both there
  double band = 0.0;       ///< half width of the 95 % band of a white sequence, 1.96 / sqrt(pairs)
  Eigen::Index pairs = 0;  ///< successive samples of which neither is missing

  /// How many times wider than stated the deviation of a constant is that is estimated from a first-order
  /// autoregression of this autocorrelation, sqrt((1 + rho) / (1 - rho)).
  [[nodiscard]] double widening() const;
};

/// Autocorrelation of normalised innovations at lag one; for a consistent filter they are white (Bar-Shalom, Li and
/// Kirubarajan 2001, section 5.4.2). A value that is not a number is missing. Zero with an infinite band where fewer
/// than two pairs are there.
Autocorrelation autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& sequence);

}  // namespace kalfem
