#include "kalfem/study/modifications_setup.hpp"

#include <algorithm>

#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

std::vector<StructuralModification> make_modifications(const CaseStudy& study, IssueList& issues) {
  const ParameterSet known(*study.structure);
  std::vector<std::string> parts;
  for (const auto& [name, part] : study.given.substructures) parts.push_back(name);
  std::vector<StructuralModification> all;
  for (const auto& [name, located] : study.given.modifications) {
    const auto& given = located.value;
    const auto& part = given.substructure;
    if (std::ranges::find(parts, part.value) == parts.end()) {
      issues.add(part.location,
                 part.path + ": there is no substructure '" + part.value + "'" + did_you_mean(part.value, parts));
      continue;
    }
    StructuralModification modification{
        {name, located.location, located.path}, part.value, {}, given.modes, given.above};
    for (const auto& [target, value] : given.set) {
      const std::string full = part.value + "." + target;
      const auto parameter = known.find(full);
      if (!parameter) {
        issues.add(value.location,
                   value.path + ": there is no parameter '" + full + "'" + did_you_mean(full, known.names()));
        continue;
      }
      try {
        modification.set.emplace_back(*parameter, checked_number(value, parameter->unit, Bounds::nonnegative()));
      } catch (const InvalidInput& error) {
        issues.add(error, value.location);
      }
    }
    all.push_back(std::move(modification));
  }
  return all;
}

}  // namespace kalfem
