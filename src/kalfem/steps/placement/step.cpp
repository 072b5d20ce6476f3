// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/steps/placement/report.hpp"
#include "kalfem/steps/run_step.hpp"

namespace kalfem {

RunStep placement_step() {
  return {.name = "place",
          .meaning = "where to put sensors",
          .asked_for = [](const Study& study) { return study.placement.has_value(); },
          .with = {"modes"},
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"place", 5.0}};
              },
          .run =
              [](RunContext& context) {
                const auto& outcome = context.results.put(place(*context.study.placement, context.job.begin("place")));
                context.results.failure = outcome.failure;
              },
          .ran = &has_outcome<PlacementOutcome>,
          .seconds = &seconds_of<PlacementOutcome>,
          .summarise =
              [](const Study&, const StudyResults& results, nlohmann::ordered_json& summary) {
                summary["placement"] = placement_summary(results.get<PlacementOutcome>());
              },
          .tell = [](const Study&,
                     const StudyResults& results) { return console_placement(results.get<PlacementOutcome>()); },
          .answer = [](const Study&,
                       const StudyResults& results) { return placement_answer(results.get<PlacementOutcome>()); },
          .sections = [](const Study& study, const StudyResults& results) -> std::vector<PlacedSection> {
            return {{PagePlace::placement, placement_section(study, results.get<PlacementOutcome>())}};
          }};
}

}  // namespace kalfem
