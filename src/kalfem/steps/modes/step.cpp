// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "kalfem/steps/modes/compute.hpp"
#include "kalfem/steps/modes/report.hpp"
#include "kalfem/steps/table.hpp"
#include "kalfem/steps/updating/outcome.hpp"

namespace kalfem {
namespace {

/// Of a run that does not take the modes, only the sizes of the substructures.
void find_modes(RunContext& context) {
  const Eigen::Index count = context.takes("modes") ? context.study.report.modes : 0;
  auto& results = context.results;
  results.phases.measure("modes", [&] {
    auto& outcome = results.put(ModesOutcome{substructure_modes(context.study, count), {}});
    outcome.joined_frequencies = joined_frequencies(context.study, count, results.warnings);
  });
}

/// Told where no other step tells of the structure.
std::string told(const Study& study, const StudyResults& results) {
  const auto ran = [&](std::string_view name) { return find_step(name)->ran(results); };
  constexpr std::array others{"simulate", "estimate", "place", "infer", "static", "frf"};
  return std::ranges::any_of(others, ran) ? "" : console_modes(study, results);
}

/// Modes of the finite-element substructures, how their reductions keep them, and what was warned of.
Section model_section(const Study& study, const StudyResults& results) {
  Section section{"Finite-element substructures", "", {}};
  if (auto table = modes_table(study, results); !table.rows.empty()) section.items.emplace_back(std::move(table));
  if (modes_found(results).joined_frequencies.size() > 0)
    section.items.emplace_back(joined_modes_table(study, results));
  for (const auto& elements : study.structure->finite_elements) {
    section.text += fmt::format("'{}' has {} degrees of freedom and weighs {}. ", elements.part->name,
                                elements.part->full.size(), mass_text(*elements.part));
    if (elements.reduced)
      section.text += fmt::format("The filter's model has {} coordinates of it: {} of the boundary, {}. ",
                                  elements.reduced->model.size(), elements.reduced->boundary.size(),
                                  elements.reduced->error_indicators.reason);
    if (auto scene = structure_scene(study, results, *elements.part)) section.items.emplace_back(std::move(*scene));
  }
  return section;
}

void write_shapes(const std::filesystem::path& folder, const Study& study, const StudyResults& results) {
  for (const auto& elements : study.structure->finite_elements)
    for (const auto& modes : modes_found(results).substructures)
      if (modes.name == elements.part->name && modes.frequencies.size() > 0 &&
          !elements.part->elements.mesh.cells.empty())
        write_modes(folder, *elements.part, modes, updated_modes_of(results, modes.name));
}

}  // namespace

RunStep modes_step() {
  return {.name = "modes",
          .meaning = "compute the natural modes of every substructure, or of a deck alone",
          .asked_for = [](const Study&) { return true; },
          .always = true,
          .run = &find_modes,
          .ran = [](const StudyResults&) { return true; },
          .summarise = [](const Study& study, const StudyResults& results,
                          nlohmann::ordered_json& summary) { summary["model"] = model_summary(study, results); },
          .tell = &told,
          .answer =
              [](const Study&, const StudyResults& results) {
                return std::string(results.has<UpdatingOutcome>() ? "" : "Modes computed.");
              },
          .sections = [](const Study& study, const StudyResults& results) -> std::vector<PlacedSection> {
            if (study.structure->finite_elements.empty()) return {};
            return {{PagePlace::model, model_section(study, results)}};
          },
          .write = &write_shapes,
          .files =
              [](const Study& study) {
                std::vector<std::string> names;
                for (const auto& elements : study.structure->finite_elements)
                  names.push_back(elements.part->name + "_modes.vtu");
                return names;
              }};
}

}  // namespace kalfem
