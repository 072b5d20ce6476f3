// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/run_study.hpp"

#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/steps/judge.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/table.hpp"
#include "kalfem/study/live_plan.hpp"
#include "kalfem/study/record_source.hpp"

namespace kalfem {

bool RunContext::takes(std::string_view step) const {
  return std::ranges::find(taken, step, &RunStep::name) != taken.end();
}

RunOptions RunContext::options_of(const std::string& step) const {
  RunOptions own = options;
  own.progress = job.begin(step);
  return own;
}

const Record& record_of(const Study& study, const StudyResults& results) {
  const auto* simulation = results.find<SimulationOutcome>();
  if (!simulation) return study.record->record;
  check_noise(study, simulation->measurements, "the simulated channel");
  return simulation->measurements;
}

namespace {

/// What the progress bar shows of the steps, with the shares of the run's time that they usually have.
std::vector<PlannedStep> plan_of(const Study& study, const std::vector<const RunStep*>& steps) {
  std::vector<PlannedStep> plan;
  for (const auto* step : steps)
    if (step->phases) std::ranges::move(step->phases(study), std::back_inserter(plan));
  return plan;
}

/// One after the other; the first failure ends the run.
void take_steps(Study& study, std::string_view verb, const RunOptions& options, StudyResults& results) {
  const auto taken = steps_of(verb, study);
  JobProgress job(plan_of(study, taken), options.progress);
  RunContext context{study, options, results, job, taken, study.augmented_model, std::nullopt};
  for (const auto& step : run_steps())
    if (results.complete() && (step.always || context.takes(step.name))) step.run(context);
}

}  // namespace

StudyResults run_study(const Study& study, std::string_view verb, const RunOptions& options) {
  Study own = study;
  return run_study(own, verb, options);
}

StudyResults run_study(Study& study, std::string_view verb, const RunOptions& options) {
  const Stopwatch watch;
  if (verb == every_step || verb == "estimate") require_no_stream(study);
  StudyResults results;
  try {
    take_steps(study, verb, options, results);
  } catch (const Interrupted&) {
    if (!options.keep_finished) throw;
    mark_interrupted(results);
  }
  results.phases.measure("verdict", [&] { judge(study, results); });
  results.total_seconds = study.load_seconds + watch.seconds();
  return results;
}

}  // namespace kalfem
