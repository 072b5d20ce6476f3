// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"

namespace kalfem {

/// A problem with the filter's model, and what is to be said of it.
struct FilterProblem {
  EstimationProblemPtr problem;
  AugmentedModelSetup setup;
  std::vector<OutputDescription> monitored;  ///< motion of the reported points, then the outputs that are asked for
};

}  // namespace kalfem
