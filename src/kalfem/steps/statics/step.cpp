// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/steps/statics/report.hpp"

namespace kalfem {

namespace {

void run_statics(RunContext& context) {
  const StaticsPlan& plan = *context.study.statics;
  const Stopwatch watch;
  StaticsOutcome outcome{statics(plan), plan.part->name, 0.0};
  outcome.seconds = watch.seconds();
  std::ranges::copy(outcome.warnings, std::back_inserter(context.results.warnings));
  context.results.put(std::move(outcome));
}

}  // namespace

RunStep statics_step() {
  return {
      .name = "static",
      .meaning = "displacements, reactions and stresses under static loads",
      .asked_for = [](const Study& study) { return study.statics.has_value(); },
      .run = &run_statics,
      .ran = &has_outcome<StaticsOutcome>,
      .seconds = &seconds_of<StaticsOutcome>,
      .summarise =
          [](const Study& study, const StudyResults& results, nlohmann::ordered_json& summary) {
            summary["statics"] = statics_summary(*study.statics, results.get<StaticsOutcome>());
          },
      .tell =
          [](const Study& study, const StudyResults& results) {
            return console_statics(*study.statics, results.get<StaticsOutcome>());
          },
      .answer =
          [](const Study&, const StudyResults& results) {
            return results.has<SimulationOutcome>() ? "" : statics_answer(results.get<StaticsOutcome>());
          },
      .sections = [](const Study& study, const StudyResults& results) -> std::vector<PlacedSection> {
        return {{PagePlace::linear_analyses, statics_section(*study.statics, results.get<StaticsOutcome>())}};
      },
      .write =
          [](const std::filesystem::path& folder, const Study& study, const StudyResults& results) {
            write_static_fields(folder, *study.statics, results.get<StaticsOutcome>());
          },
      .files = [](const Study& study) { return std::vector<std::string>{study.statics->part->name + "_static.vtu"}; }};
}

}  // namespace kalfem
