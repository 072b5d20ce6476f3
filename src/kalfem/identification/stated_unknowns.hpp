// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/fixed_numbers.hpp"

namespace kalfem {

/// A problem whose stated numbers are unknowns, with what is stated for a prior: to be integrated out.
struct StatedUnknowns {
  EstimationProblemPtr problem;                  ///< without its known_to
  std::vector<std::string> of_structure = {};    ///< states of a filter
  std::vector<std::string> of_measurement = {};  ///< gains and delays of sensors: LikelihoodUnknown
  std::vector<std::string> of_excitations = {};  ///< gains and delays of excitations, which are no unknowns

  /// Gains and delays.
  [[nodiscard]] std::vector<std::string> of_signals() const {
    std::vector<std::string> all = of_measurement;
    all.insert(all.end(), of_excitations.begin(), of_excitations.end());
    return all;
  }
};

/// The unknowns stand behind those of the problem. `setup`: of its filter.
StatedUnknowns with_stated_unknowns(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup);

}  // namespace kalfem
