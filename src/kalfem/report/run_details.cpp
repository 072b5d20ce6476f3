#include "kalfem/report/run_details.hpp"

#include <fmt/format.h>

#include "kalfem/report/tables.hpp"

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

Table timing_table(const Study& study, const StudyResults& results) {
  Table table{"Time", {"step", "seconds"}, {}, {}};
  const auto add = [&](const std::string& step, double seconds) {
    table.rows.push_back({step, fmt::format("{:.3f}", seconds)});
  };
  if (!study.structure->finite_elements.empty()) add("reduce", study.reduce_seconds);
  if (results.simulation) add("simulate", results.simulation->seconds);
  if (results.updating) add("update", results.updating->seconds);
  if (results.estimation) {
    const auto& time = results.estimation->result.time;
    add("estimate", results.estimation->seconds);
    add("  of the last filter pass: predict", time.predict);
    add("  of the last filter pass: update", time.update);
    add("  of the last filter pass: outputs", time.output);
  }
  if (results.prediction) add("predict", results.prediction->seconds);
  if (results.inference) add("infer", results.inference->seconds);
  if (results.placement) add("place", results.placement->seconds);
  add("in all", results.total_seconds);
  return table;
}

std::string console_details(const Study& study, const StudyResults& results) {
  std::string text;
  const auto add = [&](const Table& table) {
    if (!table.rows.empty()) text += table.title + "\n" + to_text(table) + "\n";
  };
  if (results.estimation) add(attempts_table(*results.estimation));
  add(timing_table(study, results));
  return text;
}

}  // namespace kalfem
