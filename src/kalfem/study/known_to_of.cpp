// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/known_to_of.hpp"

#include <algorithm>

#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

std::vector<KnownTo> known_to_of(const Named<description::Value>& given, const std::vector<FixedNumber>& numbers,
                                 IssueList& issues) {
  std::vector<KnownTo> all;
  for (const auto& [name, value] : given) {
    KnownTo known{.name = name, .relative = value.value.per_cent, .location = value.location};
    const auto of_name =
        std::ranges::find_if(numbers, [&](const FixedNumber& number) { return is_named(number, name); });
    try {
      known.deviation = known.relative || of_name == numbers.end()
                            ? value.value.value
                            : checked_number(value, of_name->unit, Bounds::positive());
      all.push_back(known);
    } catch (const InvalidInput& error) {
      issues.add(error, value.location);
    }
  }
  return all;
}

std::vector<KnownTo> known_to_of(const Named<description::Value>& given, const EstimationProblem& problem,
                                 const StructureParts& parts, const AugmentedModelSetup& setup, IssueList& issues) {
  EstimationProblem stated = problem;
  stated.settings.known_to = known_to_of(given, held_numbers(problem, parts, setup, {}), issues);
  check_known_to(stated, parts, setup, issues);
  return stated.settings.known_to;
}

}  // namespace kalfem
