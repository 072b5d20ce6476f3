// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pipeline/run_study.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/diagnosis/look_for_cause.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/pipeline/run_frequency_response.hpp"
#include "kalfem/pipeline/run_identified_case.hpp"
#include "kalfem/pipeline/run_inference.hpp"
#include "kalfem/pipeline/run_placement.hpp"
#include "kalfem/pipeline/run_simulation.hpp"
#include "kalfem/pipeline/run_statics.hpp"
#include "kalfem/pipeline/run_steps.hpp"
#include "kalfem/pipeline/run_updating.hpp"
#include "kalfem/pipeline/run_validation.hpp"
#include "kalfem/pipeline/run_verdict.hpp"
#include "kalfem/pipeline/simulation_checkpoint.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/study/study_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Takes the simulation that is given, or that of an earlier run that was killed after it, or makes it and keeps it.
void take_simulation(const Study& study, const RunOptions& options, const Progress& progress, StudyResults& results) {
  const Stopwatch watch;
  if (options.simulation) {
    results.simulation = options.simulation();
    results.simulation->seconds = watch.seconds();
    return;
  }
  const SimulationCheckpoint checkpoint(options.folder, study);
  if (auto kept = checkpoint.read()) {
    results.simulation = std::move(kept->outcome);
    results.simulation->seconds = watch.seconds();
    results.fields = std::move(kept->fields);
    return;
  }
  results.simulation = run_simulation(study, progress, results.fields, results.failure);
  if (results.complete()) checkpoint.write({*results.simulation, results.fields});
}

/// The updated structure: as the augmented model holds it, and as the prediction uses it.
struct Updated {
  AugmentedModelSetup augmented_model;
  StructureParts parts;
  VectorXd values;  ///< of its parameters
};

Updated updated_structure(const Study& study, const UpdatingOutcome& updating) {
  const StructureParts parts = study.updating_plan->structure->at(updating.values).parts;
  IssueList issues;
  AugmentedModelSetup augmented_model =
      make_augmented_model_setup(*study.problem, parts, present_values(*study.updating, updating.values), issues);
  issues.raise();
  return {std::move(augmented_model), parts, updating.values};
}

/// The structure for the prediction, at the estimates of the filter's unknowns. Nothing if it is the case's own, or if
/// the estimates are not admissible.
std::optional<CoupledModel> estimated_model(const Study& study, const AugmentedModelSetup& augmented_model,
                                            const std::optional<Updated>& updated, const EstimationOutcome& estimation,
                                            std::string& failure) try {
  const bool bound = !augmented_model.linear_unknowns.bindings.empty();
  StructureParts parts = updated ? updated->parts
                         : bound
                             ? parts_at(*study.problem, augmented_model.linear_unknowns, linear_estimates(estimation))
                             : study.structure->reference_parts();
  const auto refined = updated ? present_values(*study.updating, updated->values) : PresentValues{};
  const bool changed = set_unknowns(*study.problem, study.prediction->substructure.value,
                                    estimation.result.unknowns.mean.rightCols(1), refined, parts);
  if (!changed && !updated && !bound) return std::nullopt;
  return couple(parts);
} catch (const InvalidInput& error) {
  failure =
      "the estimates are physically impossible, so there is nothing to predict from: " + error.issues().front().what;
  return std::nullopt;
}

/// The parts that hold what the updating and the filter found, without the unknowns that connectors carry.
StructureParts parts_for_validation(const Study& study, const std::optional<AugmentedModelSetup>& augmented_model,
                                    const StudyResults& results) {
  if (results.updating) return study.updating_plan->structure->at(results.updating->values).parts;
  const auto& linear = augmented_model->linear_unknowns;
  return linear.bindings.empty() ? study.structure->parts
                                 : parts_at(*study.problem, linear, linear_estimates(*results.estimation));
}

/// Final estimates of the filter's unknowns before the updating.
VectorXd unknowns_at_start(const Study& study, const StudyResults& results) {
  const auto before = estimate_record(study.problem, *study.augmented_model, record_of(study, results));
  return before.result.failure ? VectorXd() : VectorXd(before.result.unknowns.mean.rightCols(1));
}

/// The natural frequencies over time that the report asks for. Estimates that are not admissible have none.
std::optional<FrequencyCourse> frequencies_of(const Study& study, const StructureParts& parts,
                                              const AugmentedModelSetup& setup, StudyResults& results) try {
  return frequency_course(*study.problem, parts, setup, *results.estimation, study.report.frequencies);
} catch (const InvalidInput& error) {
  results.warnings.push_back("no natural frequencies over time: an estimate is physically impossible on the way (" +
                             error.issues().front().what + ")");
  return std::nullopt;
}

std::optional<UpdatedParameters> updated_parameters(const StudyResults& results) {
  if (!results.updating) return std::nullopt;
  return UpdatedParameters{results.updating->values, results.updating->statistics};
}

/// Suspicions become warnings, and so does what the second thoughts left out.
void judge(const Study& study, StudyResults& results) {
  if (results.estimation && results.estimation->second_thoughts == SecondThoughts::stopped && !results.interrupted)
    results.warnings.push_back(fmt::format("not looked for, as second_thoughts: {:g} allow no more filter steps: {}",
                                           study.problem->settings.second_thoughts,
                                           fmt::join(results.estimation->left_out, "; ")));
  results.verdict = verdict_of(study, results);
  for (const auto& reason : results.verdict.reasons())
    if (reason.state == VerdictState::suspicious) results.warnings.push_back(sentence_of(reason));
}

/// Keeps the first answer, should the run be stopped, and hands it over, judged.
void tell_first(const Study& study, const RunOptions& options, EstimationOutcome first, StudyResults& results) {
  results.estimation = std::move(first);
  if (!options.on_first_answer) return;
  const auto warnings = results.warnings;
  results.failure = results.estimation->failure();
  judge(study, results);
  results.identified = identified_case_of(study, results);
  options.on_first_answer(results);
  results.warnings = warnings;
  results.failure.clear();
}

}  // namespace

const Record& record_of(const Study& study, const StudyResults& results) {
  if (!results.simulation) return study.record->record;
  check_noise(study, results.simulation->measurements, "the simulated channel");
  return results.simulation->measurements;
}

namespace {

/// Whether a run that ends with `last` takes this step.
bool takes(Step step, Step last) {
  if (last == Step::everything) return true;
  if (last == Step::infer) return step == Step::simulate || step == Step::estimate || step == Step::infer;
  if (last == Step::place || last == Step::statics || last == Step::frequency_response) return step == last;
  return step <= last;
}

/// The steps that the run will take, with the shares of its time that they usually have.
std::vector<PlannedStep> plan_of(const Study& study, Step last) {
  const bool updates = takes(Step::update, last) && study.updating;
  const bool estimates = takes(Step::estimate, last) && study.augmented_model;
  std::vector<PlannedStep> plan;
  const auto add = [&](bool taken, const char* name, double share) {
    if (taken) plan.push_back({name, share});
  };
  add(takes(Step::frequency_response, last) && study.frequency_response, "frequency responses", 3.0);
  add(takes(Step::simulate, last) && study.simulation, "simulate", 4.0);
  add(updates, "update", 6.0);
  add(estimates, "estimate", 3.0);
  add(estimates && study.problem->settings.diagnose, "diagnose", 1.0);
  add(study.validation && (estimates || updates), "validate", 1.0);
  add(takes(Step::predict, last) && study.prediction, "predict", 2.0);
  add(takes(Step::infer, last) && study.inference, "infer", 10.0);
  add(takes(Step::place, last) && study.placement, "place", 5.0);
  return plan;
}

void take_steps(const Study& study, Step last, const RunOptions& options, StudyResults& results) {
  JobProgress job(plan_of(study, last), options.progress);
  const auto options_of = [&](const char* step) {
    RunOptions own = options;
    own.progress = job.begin(step);
    return own;
  };
  const bool updates = takes(Step::update, last) && study.updating;
  const bool without_modes = last == Step::statics || last == Step::frequency_response;
  results.phases.measure("modes", [&] {
    const Eigen::Index count = without_modes ? 0 : study.report.modes;
    results.modes = substructure_modes(study, count);
    results.joined_frequencies = joined_frequencies(study, count, results.warnings);
  });
  if (takes(Step::statics, last) && study.statics) results.statics = run_statics(*study.statics, results.warnings);
  if (takes(Step::frequency_response, last) && study.frequency_response)
    results.frequency_response = results.phases.measure("frequency_response", [&] {
      return run_frequency_response(*study.frequency_response, job.begin("frequency responses"), results.warnings);
    });
  if (takes(Step::simulate, last) && study.simulation) take_simulation(study, options, job.begin("simulate"), results);
  std::optional<Updated> updated;
  if (results.complete() && updates) {
    results.updating = run_updating(study, results, options_of("update"), results.failure);
    if (study.augmented_model && results.complete()) {
      results.updating->unknowns_before = unknowns_at_start(study, results);
      updated.emplace(updated_structure(study, *results.updating));
    }
  }
  std::optional<AugmentedModelSetup> augmented_model = updated ? updated->augmented_model : study.augmented_model;
  if (results.complete() && takes(Step::estimate, last) && augmented_model) {
    results.estimation =
        run_estimation(study, *augmented_model, results, job.begin("estimate"),
                       [&](EstimationOutcome first) { tell_first(study, options, std::move(first), results); });
    results.failure = results.estimation->failure();
    job.begin("diagnose");
    const StructureParts& parts = updated ? updated->parts : study.structure->parts;
    results.estimation->diagnosis = results.phases.measure("diagnose", [&] {
      return look_for_cause(*study.problem, parts, record_of(study, results), *results.estimation);
    });
    if (results.complete() && study.report.frequencies > 0)
      results.estimation->frequencies = frequencies_of(study, parts, *augmented_model, results);
    if (results.complete() && !updated &&
        augmented_model->linear_unknowns.bindings
            .empty())  // otherwise the pictures have another basis than the augmented model
      if (auto series = estimated_fields(study, *results.estimation)) results.fields.push_back(std::move(*series));
  }
  if (results.complete() && study.validation && (results.estimation || results.updating)) {
    job.begin("validate");
    results.validation = results.phases.measure("validate", [&] {
      return run_validation(study, parts_for_validation(study, augmented_model, results), results);
    });
    if (results.estimation && results.validation->one_step_left_out)
      results.estimation->leave_out("the prediction of the validation one sample ahead");
  }
  if (results.complete() && takes(Step::predict, last) && study.prediction) {
    const auto estimated = estimated_model(study, *augmented_model, updated, *results.estimation, results.failure);
    if (results.complete())
      results.prediction = run_prediction(study, estimated ? *estimated : *study.model, results, job.begin("predict"));
  }
  if (results.complete() && takes(Step::predict, last))
    results.modifications = predict_modifications(study, updated_parameters(results));
  if (results.complete() && takes(Step::infer, last) && study.inference)
    results.inference = run_inference(study, results, options_of("infer"));
  if (results.complete() && takes(Step::place, last) && study.placement) {
    results.placement = run_placement(study, job.begin("place"));
    results.failure = results.placement->failure;
  }
}

}  // namespace

StudyResults run_study(const Study& study, Step last, const RunOptions& options) {
  const Stopwatch watch;
  StudyResults results;
  try {
    take_steps(study, last, options, results);
  } catch (const Interrupted&) {
    if (!options.keep_finished) throw;
    results.interrupted = true;
    results.failure = "the run was stopped before its end";
    if (results.estimation && results.estimation->second_thoughts == SecondThoughts::pending)
      results.estimation->second_thoughts = SecondThoughts::stopped;
  }
  results.phases.measure("verdict", [&] {
    judge(study, results);
    results.identified = identified_case_of(study, results);
  });
  results.total_seconds = study.load_seconds + watch.seconds();
  return results;
}

std::string StudyResults::why_unusable() const {
  const auto reasons = verdict.reasons();
  if (reasons.empty() || reasons.front().state != VerdictState::unusable) return failure;
  return sentence_of(reasons.front());
}

}  // namespace kalfem
