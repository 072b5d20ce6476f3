// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/steps/reported_quantities.hpp"
#include "kalfem/study/structural_modifications.hpp"

namespace kalfem {

/// The motion of a substructure that is driven by its estimated boundary.
struct PredictionOutcome {
  std::string substructure;
  std::vector<PointQuantity> points;
  double seconds = 0.0;
};

/// The natural frequencies after each structural modification of the case.
struct ModificationsOutcome {
  std::vector<StructuralModificationResult> modifications;  ///< of all choices of parameters, where there are several
  /// By choice of parameters, then by modification; empty where there is one choice.
  std::vector<std::pair<std::string, std::vector<StructuralModificationResult>>> by_choice = {};
};

}  // namespace kalfem
