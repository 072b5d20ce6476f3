// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/steps/placement/report.hpp"
#include "kalfem/steps/run_step.hpp"

namespace kalfem {

namespace {

PlacementProblem problem_of(const Study& study) {
  const auto& plan = *study.placement;
  return {.problem = study.problem,
          .candidates = plan.candidates,
          .own = plan.own,
          .unknowns = plan.unknowns,
          .units = plan.units,
          .initial = plan.initial,
          .prior = plan.prior,
          .counted = plan.counted,
          .options = plan.options,
          .draws = plan.draws,
          .seed = plan.seed,
          .drive = plan.drive};
}

}  // namespace

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
                const auto& outcome = context.results.put(place(problem_of(context.study), context.job.begin("place")));
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
