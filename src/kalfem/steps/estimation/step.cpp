// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/look_for_cause.hpp"
#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/steps/estimation/compute.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/report.hpp"
#include "kalfem/steps/judge.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/study/live_plan.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

/// The natural frequencies over time that the report asks for. Estimates that are not admissible have none.
std::optional<FrequencyCourse> frequencies_of(RunContext& context, const StructureParts& parts) try {
  const Study& study = context.study;
  return frequency_course(*study.problem, parts, *context.augmented_model, context.results.get<EstimationOutcome>(),
                          study.report.frequencies);
} catch (const InvalidInput& error) {
  context.results.warnings.push_back(
      "no natural frequencies over time: an estimate is physically impossible on the way (" +
      error.issues().front().what + ")");
  return std::nullopt;
}

/// The parameters of the updating whose values the model of this run has.
std::vector<std::string> updated_parameters(const RunContext& context) {
  std::vector<std::string> names;
  if (context.updated)
    for (const auto& [index, target] : context.study.updating->bindings) names.push_back(target.name);
  return names;
}

/// Which mistake explains it where the numbers contradict themselves.
void diagnose(RunContext& context, const StructureParts& parts, EstimationOutcome& outcome) {
  const Study& study = context.study;
  context.job.begin("diagnose");
  outcome.diagnosis = context.results.phases.measure("diagnose", [&] {
    return look_for_cause(*study.problem, parts, record_of(study, context.results), outcome,
                          updated_parameters(context));
  });
}

void estimate(RunContext& context) {
  const Study& study = context.study;
  auto& results = context.results;
  auto& outcome = results.put(run_estimation(
      study, *context.augmented_model, results, updated_parameters(context), context.job.begin("estimate"),
      [&](EstimationOutcome first) { tell_first(study, context.options, std::move(first), results); }));
  results.failure = outcome.failure();
  if (outcome.freed && outcome.freed->taken) context.study = study_with(study, outcome.freed->kept());
  const StructureParts& parts = context.updated ? *context.updated : study.structure->parts;
  diagnose(context, parts, outcome);
  if (!results.complete()) return;
  if (!study.alternatives.empty()) run_alternatives(study, results, context.job.begin("alternatives"), outcome);
  if (auto words = unlikely_law_words(study, outcome); !words.empty()) results.warnings.push_back(std::move(words));
  if (study.problem->settings.smooth && !outcome.smoothed)
    results.warnings.push_back(
        "estimate.smooth: the estimates from the whole record are missing: rounding stopped the smoother with every "
        "form "
        "of the filter; state the noise of the sensors and the deviation of unknown inputs as large as they are, or "
        "leave smooth out");
  if (study.report.frequencies > 0) outcome.frequencies = frequencies_of(context, parts);
  // Otherwise the pictures have another basis than the augmented model.
  if (!context.updated && context.augmented_model->linear_unknowns.bindings.empty())
    if (auto series = estimated_fields(study, outcome)) outcome.fields.push_back(std::move(*series));
}

std::vector<PlannedStep> phases(const Study& study) {
  std::vector<PlannedStep> phases{{"estimate", 3.0}};
  if (study.problem->settings.diagnose) phases.push_back({"diagnose", 1.0});
  if (!study.alternatives.empty()) phases.push_back({"alternatives", 3.0 * std::ssize(study.alternatives)});
  return phases;
}

void summarise(const Study& study, const StudyResults& results, Json& summary) {
  const auto& outcome = results.get<EstimationOutcome>();
  summary["parameters"] = parameters_summary(study, outcome);
  if (!outcome.inputs.empty()) {
    summary["inputs"] = inputs_summary(outcome.inputs, outcome.settled);
    summary["hardly_known"] = outcome.hardly_known;
  }
  Json estimation = estimation_summary(outcome);
  if (!outcome.left_out.empty()) estimation["left_out"] = outcome.left_out;
  if (outcome.result.noise) estimation["adaptive_noise"] = adaptive_noise_summary(outcome);
  if (!outcome.process_noise.empty()) estimation["process_noise"] = process_noise_summary(outcome);
  if (!outcome.alternatives.empty()) {
    estimation["weight"] = number(outcome.weight);
    estimation["alternatives"] = alternatives_summary(study, outcome);
  }
  summary["estimation"] = std::move(estimation);
  if (outcome.fixed_numbers) summary["sensitivity"] = sensitivity_summary(outcome);
  if (outcome.freed && !outcome.freed->tried.empty()) summary["freed"] = freed_summary(*outcome.freed);
  if (outcome.held_out_sensors) summary["held_out"] = held_out_summary(*outcome.held_out_sensors);
  if (!outcome.events.empty()) summary["events"] = events_summary(outcome);
  if (outcome.frequencies) summary["frequencies"] = frequencies_summary(*outcome.frequencies);
  if (outcome.smoothed) summary["smoothed"] = smoothed_summary(outcome);
  if (outcome.diagnosis) summary["diagnosis"] = diagnosis_summary(*outcome.diagnosis);
}

/// What was identified, and by which law where several were compared.
std::string answer(const Study& study, const StudyResults& results) {
  const std::string identified = estimation_answer(study, results.get<EstimationOutcome>());
  const auto* inference = results.find<InferenceOutcome>();
  const std::string law = inference ? law_words(*inference) : "";
  return identified + (law.empty() ? "" : " " + law);
}

std::vector<PlacedSection> sections(const Study& study, const StudyResults& results) {
  const auto& outcome = results.get<EstimationOutcome>();
  std::vector<PlacedSection> all;
  const auto add = [&](PagePlace place, Section section) { all.push_back({place, std::move(section)}); };
  if (!outcome.events.empty()) add(PagePlace::events, events_section(outcome.events));
  if (!outcome.has_samples()) return all;
  add(study.record ? PagePlace::measured : PagePlace::sensors, sensors_section(study, outcome));
  if (outcome.augmented_model->layout().unknowns > 0) add(PagePlace::parameters, parameters_section(study, outcome));
  if (!outcome.alternatives.empty()) add(PagePlace::parameters, alternatives_section(study, outcome));
  if (outcome.fixed_numbers) add(PagePlace::parameters, sensitivity_section(outcome));
  if (outcome.freed && !outcome.freed->tried.empty()) add(PagePlace::parameters, freed_section(*outcome.freed));
  if (outcome.frequencies) add(PagePlace::motion, frequencies_section(*outcome.frequencies));
  if (outcome.result.noise) add(PagePlace::motion, adaptive_noise_section(outcome));
  if (!outcome.process_noise.empty()) add(PagePlace::motion, process_noise_section(outcome));
  if (!outcome.inputs.empty()) add(PagePlace::motion, inputs_section(outcome));
  if (outcome.open_loop) add(PagePlace::motion, open_loop_section(outcome));
  if (!outcome.open_loop_failure.empty())
    add(PagePlace::motion,
        {"Open-loop simulation of the record", "No comparison: " + outcome.open_loop_failure + ".", {}});
  add(PagePlace::motion, motion_section(study, outcome));
  if (auto section = connectors_section(study, outcome); !section.items.empty())
    add(PagePlace::motion, std::move(section));
  add(PagePlace::consistency, consistency_section(outcome));
  if (outcome.held_out_sensors) add(PagePlace::consistency, held_out_section(*outcome.held_out_sensors));
  return all;
}

}  // namespace

RunStep estimation_step() {
  return {.name = "estimate",
          .meaning = "estimate the states and the unknown parameters, running the steps this needs",
          .asked_for = [](const Study& study) { return study.augmented_model.has_value() && !is_live(study); },
          .with = {"simulate"},
          .phases = &phases,
          .run = &estimate,
          .ran = &has_outcome<EstimationOutcome>,
          .seconds = &seconds_of<EstimationOutcome>,
          .summarise = &summarise,
          .tell =
              [](const Study& study, const StudyResults& results) {
                return console_estimation(study, results.get<EstimationOutcome>(), results.verdict);
              },
          .answer = &answer,
          .sections = &sections,
          .visit = [](const Study&, const StudyResults& results,
                      SeriesWriter& file) { write_estimate(file, results.get<EstimationOutcome>()); },
          .write =
              [](const std::filesystem::path& folder, const Study& study, const StudyResults& results) {
                write_field_series(folder, study, results.get<EstimationOutcome>().fields);
              }};
}

}  // namespace kalfem
