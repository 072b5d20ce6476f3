// SPDX-License-Identifier: Apache-2.0
#include "kalfem/analysis/read_updating.hpp"

#include <cmath>

#include "kalfem/study/updating_setup.hpp"

namespace kalfem {
namespace {

MeasuredModes modes_of(const description::ModalData& given) {
  MeasuredModes modes{.substructure = given.substructure.value, .frequencies = {}, .above = given.above};
  for (const auto& mode : listed_modes(given))
    modes.frequencies.push_back({mode.frequency, mode.deviation, mode.model_mode});
  return modes;
}

}  // namespace

UpdateOptions update_options_of(const Study& study) {
  const auto& given = *study.description->update;
  UpdateOptions options{.parameters = {},
                        .max_evaluations = given.stages,
                        .known_to = study.updating_plan->known_to,
                        .tolerance = given.tolerance};
  for (const auto& parameter : study.updating->parameters) {
    RefinedParameter refined{
        .name = parameter.name,
        .range = {.initial = parameter.initial, .lower = parameter.lower, .upper = parameter.upper}};
    if (std::isfinite(parameter.deviation)) refined.range.std = parameter.deviation;
    options.parameters.push_back(refined);
  }
  for (const auto& [name, comparison] : given.comparisons)
    options.comparisons.push_back({.name = name,
                                   .what = modes_of(std::get<description::ModalData>(comparison.value.data)),
                                   .weight = comparison.value.weight});
  return options;
}

}  // namespace kalfem
