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
  std::vector<MeasuredMode> measured = {};
  std::vector<DofCombination> points =
      {};              ///< of their shapes, as combinations of the substructure's degrees of freedom
  double above = 0.0;  ///< [Hz] modes of the model up to this frequency are not elastic ones
};

struct CorrelationOutcome {
  std::vector<CorrelatedComparison> comparisons;
  bool updated = false;  ///< with the updated model; otherwise as the case gives it
  double seconds = 0.0;
};

}  // namespace kalfem
