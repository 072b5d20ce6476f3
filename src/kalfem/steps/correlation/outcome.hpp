// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/correlation/correlate.hpp"

namespace kalfem {

/// A comparison of modes, mode by mode and sensor by sensor.
struct CorrelatedComparison {
  std::string name;
  std::string substructure;
  Correlation correlation;
};

struct CorrelationOutcome {
  std::vector<CorrelatedComparison> comparisons;
  bool updated = false;  ///< with the updated model; otherwise as the case gives it
  double seconds = 0.0;
};

}  // namespace kalfem
