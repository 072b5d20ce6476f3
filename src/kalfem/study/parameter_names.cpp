#include "kalfem/study/parameter_names.hpp"

#include <algorithm>

namespace kalfem {

std::vector<Name> names_of(const std::string& name, const description::Unknown& given) {
  if (!given.applies_to.empty()) return given.applies_to;
  return {{name, given.initial.location, "estimate.unknown." + name}};
}

std::optional<Issue> unlike_ratios(const description::Case& given, const Parameter& parameter, const Name& name) {
  if (!parameter.name.ends_with(".damping.modal")) return std::nullopt;
  const auto& ratios =
      std::ranges::find(given.substructures, parameter.owner, &std::pair<std::string, description::Substructure>::first)
          ->second.damping.modal;
  if (std::ranges::adjacent_find(ratios, std::ranges::not_equal_to{}) == ratios.end()) return std::nullopt;
  std::string listed;
  for (const double ratio : ratios) listed += (listed.empty() ? "" : ", ") + shortest(100.0 * ratio) + " %";
  return name.issue(
      "'" + parameter.name + "' stands for all modal ratios as one number, and the case gives [" + listed + "]",
      "these would all become the same",
      "name single ratios, " + parameter.name + ".1 and so on; several share a value by applies_to");
}

}  // namespace kalfem
