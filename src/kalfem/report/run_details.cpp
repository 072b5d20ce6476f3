// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/console_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

Table attempts_table(const EstimationOutcome& outcome) {
  Table table{"Filters that were tried", {"filter", "coordinates", "outcome"}, {}, {}};
  for (const auto& [filter, coordinates, failure] : outcome.attempts)
    table.rows.push_back({to_string(filter), coordinates == StateCoordinates::modal ? "modal" : "physical",
                          failure
                              ? fmt::format("stopped at {} s: {}",
                                            four_digits(outcome.measurements.start + failure->time), failure->reason)
                              : "usable"});
  return table;
}

}  // namespace

PhaseTimes step_times(const Study& study, const StudyResults& results) {
  PhaseTimes times;
  times.add("load", std::max(0.0, study.load_seconds - study.reduce_seconds));
  if (!study.structure->finite_elements.empty()) times.add("reduce", study.reduce_seconds);
  for (const auto& step : run_steps())
    if (step.seconds)
      if (const auto seconds = step.seconds(results)) times.add(std::string(step.name), *seconds);
  times.add(results.phases);
  return times;
}

Table timing_table(const Study& study, const StudyResults& results) {
  Table table{"Time", {"step", "seconds"}, {}, {}};
  const auto add = [&](std::string step, double seconds) {
    std::ranges::replace(step, '_', ' ');
    table.rows.push_back({step, fmt::format("{:.3f}", seconds)});
  };
  const PhaseTimes times = step_times(study, results);
  for (const auto& [step, seconds] : times.list()) {
    add(step, seconds);
    if (step == "reduce")
      for (const auto& [part, own] : study.reduce_phases.list()) add("  of that: " + part, own);
    if (step == "estimate") {
      const auto& time = results.get<EstimationOutcome>().result.time;
      add("  of the last filter pass: predict", time.predict);
      add("  of the last filter pass: update", time.update);
      add("  of the last filter pass: outputs", time.output);
    }
  }
  add("in all", results.total_seconds);
  return table;
}

std::string console_details(const Study& study, const StudyResults& results) {
  std::string text;
  const auto add = [&](const Table& table) {
    if (!table.rows.empty()) text += table.title + "\n" + to_text(table) + "\n";
  };
  if (const auto* estimation = results.find<EstimationOutcome>()) add(attempts_table(*estimation));
  add(timing_table(study, results));
  return text;
}

}  // namespace kalfem
