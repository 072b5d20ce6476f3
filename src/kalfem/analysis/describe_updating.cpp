// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "kalfem/analysis/case_sections.hpp"

namespace kalfem {
namespace {

namespace d = description;

d::Value bare(double value) { return {{value, {}, true}, {}, {}}; }

/// The part of the frequencies that their deviations are, where one is, to the last bit of each: a case states one
/// deviation for all, most often in per cent.
std::optional<double> common_part(const std::vector<MeasuredFrequency>& frequencies) {
  const double first = frequencies.front().std / frequencies.front().frequency;
  for (int digits = 1; digits <= 17; ++digits) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, first);
    const double part = std::strtod(text.data(), nullptr);
    if (std::ranges::all_of(frequencies, [&](const auto& each) { return part * each.frequency == each.std; }))
      return part;
  }
  return std::nullopt;
}

std::optional<d::Value> common_deviation(const std::vector<MeasuredFrequency>& frequencies) {
  const double first = frequencies.front().std;
  if (std::ranges::all_of(frequencies, [&](const auto& each) { return each.std == first; })) return bare(first);
  if (const auto part = common_part(frequencies)) return d::Value{{*part, {}, false, true}, {}, {}};
  return std::nullopt;
}

d::UpdatedParameter described(const RefinedParameter& given, CaseInMaking& making) {
  d::UpdatedParameter parameter;
  const auto& range = given.range;
  if (range.initial) parameter.initial = bare(*range.initial);
  if (range.std) parameter.std = bare(*range.std);
  if (std::isfinite(range.upper))
    parameter.bounds = {{Quantity{.value = range.lower}, Quantity{.value = range.upper}}, {}, {}};
  else if (range.lower != 0.0)
    making.refuse("the parameter '" + given.name + "' has a lower bound alone", "a case states both bounds",
                  "give an upper one");
  return parameter;
}

d::ModalData described(const std::string& name, const MeasuredModes& given, CaseInMaking& making) {
  d::ModalData modes{.substructure = {given.substructure, {}, {}}, .above = given.above};
  std::vector<double> frequencies;
  for (const auto& each : given.frequencies) {
    frequencies.push_back(each.frequency);
    if (each.mode) modes.model_modes.push_back(*each.mode);
  }
  const auto deviation = given.frequencies.empty() ? bare(0.0) : common_deviation(given.frequencies);
  if (!deviation)
    making.refuse("the frequencies of '" + name + "' have deviations of their own",
                  "a case states one for all, in Hz or in per cent", "make a comparison of each kind");
  modes.deviation = deviation.value_or(bare(0.0));
  modes.measured = d::ListedModes{.frequencies = {std::move(frequencies), {}, {}}};
  if (!modes.model_modes.empty() && modes.model_modes.size() != given.frequencies.size())
    making.refuse("some frequencies of '" + name + "' name their modes", "a case names those of all or of none", "");
  if (given.shapes.size() > 0)
    making.refuse("'" + name + "' has mode shapes", "a case reads them from a table", "leave them out");
  return modes;
}

}  // namespace

void describe_updating(const UpdateOptions& options, CaseInMaking& making) {
  auto& update = making.given.update.emplace();
  update.stages = options.max_evaluations;
  update.tolerance = options.tolerance;
  for (const auto& known : options.known_to)
    update.known_to.push_back({known.name, {{known.deviation, {}, !known.relative, known.relative}, {}, {}}});
  for (const auto& parameter : options.parameters)
    update.parameters.push_back({parameter.name, {described(parameter, making), {}, {}}});
  const auto add = [&](const std::string& name, const MeasuredModes& modes, double weight) {
    update.comparisons.push_back({name, {{described(name, modes, making), weight}, {}, {}}});
  };
  if (!options.frequencies.empty())
    add("frequencies",
        {.substructure = options.substructure, .frequencies = options.frequencies, .above = options.above}, 1.0);
  for (const auto& [name, what, weight] : options.comparisons)
    if (const auto* modes = std::get_if<MeasuredModes>(&what))
      add(name, *modes, weight);
    else
      making.refuse("'" + name + "' compares with something else than natural frequencies",
                    "other measurements are in files of their own", "write its section by hand");
}

}  // namespace kalfem
