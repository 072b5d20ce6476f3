// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/validate.hpp"

#include <cmath>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/sensor_record.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/diagnosis/judge_validation.hpp"
#include "kalfem/validation/validation.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Lead-in of a record, as a fraction of it, if none is given.
constexpr double usual_lead_in = 0.1;

void check(const ValidateOptions& options, const Record& record, IssueList& issues) {
  constexpr Index fewest_samples = 4;  // two of a lead-in and two that count
  if (record.samples() < fewest_samples)
    issues.add({}, "record: it has " + std::to_string(record.samples()) + " samples", "an error of so few says nothing",
               "take a longer record");
  if (!options.lead_in) return;
  const double length = record.end() - record.start;
  if (options.from_rest)
    issues.add({}, "lead_in: it is given with from_rest", "a known initial state is not estimated",
               "leave one of them out");
  if (!(*options.lead_in >= 0.0) || !(*options.lead_in < length))
    issues.add({},
               "lead_in: it is " + shortest(*options.lead_in) + " s, but the record is " + shortest(length) + " s long",
               "what lies behind the lead-in is compared", "give a shorter lead-in, >= 0");
}

/// The inputs must be known over the whole record.
void check_inputs(const StructureDescription& description, const Record& record, IssueList& issues) {
  for (std::size_t i = 0; i < description.signals.size(); ++i)
    collect("input '" + description.parts.inputs[i].name + "': ", issues, [&] {
      for (const double time : {record.start, record.end()})
        static_cast<void>(description.signals[i]->sample(time, 1.0, 1));
    });
}

/// The question in the library's own types.
ValidationProblem problem_of(const Structure& structure, const Record& record, const ValidateOptions& options) {
  IssueList issues;
  collect("", issues, [&] { require_channels(record, options.sensors); });
  collect("", issues, [&] { require_signals(structure.description()); });
  if (issues.empty()) {
    check(options, record, issues);
    check_inputs(structure.description(), record, issues);
  }
  Structure moved = structure;
  FilterProblem made;
  collect("values: ", issues, [&] { moved = structure.at(options.values); });
  collect("", issues, [&] {
    made = make_filter_problem(moved, record.sample_rate,
                               {.sensors = options.sensors,
                                .process_noise = options.process_noise,
                                .filter = options.filter,
                                .substeps = options.substeps,
                                .threads = options.threads});
  });
  issues.raise();
  const auto& problem = *made.problem;
  return {.structure = {problem.structure, problem.structure->parts, problem.sensors, problem.settings, {}},
          .held_back = {.record = {record_of_sensors(record, options.sensors)},
                        .signals = problem.structure->signals,
                        .lead_in = options.lead_in.value_or(usual_lead_in * (record.end() - record.start)),
                        .from_rest = options.from_rest},
          .own = {}};
}

}  // namespace

ValidateResult validate(const Structure& structure, const Record& record, const ValidateOptions& options) {
  const ValidationProblem problem = problem_of(structure, record, options);
  const Validation found = validate(problem);
  const auto& comparison = found.held_back;
  ValidateResult result{.measured = problem.held_back.record.record,
                        .simulated = comparison.simulated,
                        .compared_from = record.time(comparison.first),
                        .failure = comparison.failure};
  result.verdict.add(reasons_of(found));
  for (std::size_t j = 0; j < options.sensors.size(); ++j) {
    auto& sensor = result.sensors.emplace_back();
    sensor.sensor = options.sensors[j].name;
    sensor.unit = unit_of(options.sensors[j].output);
    if (j < comparison.nrmse.size()) sensor.nrmse = comparison.nrmse[j];
    if (j < comparison.noise.size()) sensor.noise = comparison.noise[j];
    if (j < comparison.one_step.size()) sensor.one_step = comparison.one_step[j];
  }
  return result;
}

}  // namespace kalfem
