// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/stated_unknowns.hpp"

#include "kalfem/identification/freed_numbers.hpp"

namespace kalfem {

StatedUnknowns with_stated_unknowns(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup) {
  StatedUnknowns found{.problem = problem};
  const auto stated = stated_numbers(held_numbers(*problem, *setup.parts, setup, {}), problem->settings.known_to);
  for (const auto& number : stated) {
    if (!can_be_freed(number)) {
      found.of_excitations.push_back(number.name);
      continue;
    }
    found.problem = with_unknown(*found.problem, number, number.deviation * number.scale);
    (number.parameter ? found.of_structure : found.of_measurement).push_back(name_as_unknown(number));
  }
  auto without = std::make_shared<EstimationProblem>(*found.problem);
  without->settings.known_to.clear();
  found.problem = std::move(without);
  return found;
}

}  // namespace kalfem
