// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/input_error.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

Eigen::VectorXd input_error_power(const RecordSpectra& spectra) {
  const Eigen::Index uppermost = std::max<Eigen::Index>(1, spectra.input.size() / 10);
  const double power = spectra.input.tail(uppermost).cwiseAbs2().mean();
  const auto beyond = spectra.sample_rate - spectra.lines.array();
  return power * (0.5 * spectra.sample_rate / beyond).pow(4);
}

}  // namespace kalfem
