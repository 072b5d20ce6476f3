// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/estimate.hpp"

namespace kalfem::benchmarks {

/// The chain of the worked example with any number of masses: wheel on a moving ground, saturating suspension with
/// unknown mu_k1 and mu_c1, upper masses, four noisy accelerometers spread along it, and a record of its motion.
struct ChainCase {
  std::unique_ptr<AugmentedModel> augmented_model;  ///< in physical coordinates
  std::unique_ptr<AugmentedModel>
      modal_augmented_model;  ///< the same in modal coordinates, for partially linear filters
  FilterInput record;
};

/// `states` is the size of the augmented state, 2 (masses) + 2; even, at least 12. Record of the given samples at 1
/// kHz.
ChainCase chain_case(Eigen::Index states, Eigen::Index samples);

}  // namespace kalfem::benchmarks
