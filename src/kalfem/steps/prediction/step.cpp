// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/point_errors.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/prediction/section.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/updating/compute.hpp"
#include "kalfem/study/structural_modifications.hpp"
#include "kalfem/vibration/driven_motion.hpp"

// Two predictions: the motion of a substructure that its estimated boundary drives, and the natural frequencies after
// changes to the structure.

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

/// The structure for the prediction, at the estimates of the filter's unknowns. Nothing if it is the case's own, or if
/// the estimates are not admissible.
std::optional<CoupledModel> estimated_model(RunContext& context, const EstimationOutcome& estimation) try {
  const Study& study = context.study;
  const AugmentedModelSetup& augmented_model = *context.augmented_model;
  const auto& updated = context.updated;
  const bool bound = !augmented_model.linear_unknowns.bindings.empty();
  StructureParts parts = updated ? *updated
                         : bound
                             ? parts_at(*study.problem, augmented_model.linear_unknowns, linear_estimates(estimation))
                             : study.structure->reference_parts();
  const auto refined =
      updated ? present_values(*study.updating, context.results.get<UpdatingOutcome>().values) : PresentValues{};
  const bool changed = set_unknowns(*study.problem, study.prediction->substructure.value,
                                    estimation.result.unknowns.mean.rightCols(1), refined, parts);
  if (!changed && !updated && !bound) return std::nullopt;
  return couple(parts);
} catch (const InvalidInput& error) {
  context.results.failure =
      "the estimates are physically impossible, so there is nothing to predict from: " + error.issues().front().what;
  return std::nullopt;
}

UpdatedParameters parameters_of(const UpdatingOutcome& updating) {
  return {updating.values, updating.statistics, updating.considered};
}

/// By the updated parameters, or by all choices of them with their weights.
ModificationsOutcome predicted_modifications(const Study& study, const StudyResults& results) {
  const auto* updating = results.find<UpdatingOutcome>();
  if (!updating) return {predict_modifications(study, std::nullopt)};
  ModificationsOutcome found{predict_modifications(study, parameters_of(*updating))};
  if (found.modifications.empty() || updating->alternatives.empty()) return found;
  std::vector<double> weights{updating->weight};
  found.by_choice.emplace_back("as given", found.modifications);
  for (const auto& each : updating->alternatives) {
    if (!each.failure.empty()) continue;
    weights.push_back(each.outcome.weight);
    found.by_choice.emplace_back(
        each.plan->name, predict_modifications(with_alternative(study, *each.plan), parameters_of(each.outcome)));
  }
  for (std::size_t i = 0; i < found.modifications.size(); ++i) {
    std::vector<StructuralModificationResult> models;
    for (const auto& [name, predicted] : found.by_choice) models.push_back(predicted[i]);
    found.modifications[i] = mixed(models, Eigen::VectorXd::Map(weights.data(), std::ssize(weights)));
  }
  return found;
}

/// Drives the case's substructure, as the model holds it, by the estimated motion of its boundary.
std::vector<DrivenQuantity> driven_motion(const Study& study, std::shared_ptr<const CoupledModel> model,
                                          const EstimationOutcome& estimation, const Progress& progress) try {
  return kalfem::predict({.structure = study.structure,
                          .model = std::move(model),
                          .substructure = study.prediction->substructure.value,
                          .estimated =
                              [&](const std::string& point, ObservedQuantity quantity) {
                                const auto* found = find_quantity(estimation.points, point, quantity);
                                return found ? &found->mean : nullptr;
                              },
                          .start = estimation.measurements.start,
                          .sample_rate = study.sample_rate(),
                          .samples = estimation.measurements.samples(),
                          .substeps = study.prediction->substeps},
                         progress);
} catch (const InvalidInput& error) {
  IssueList issues;
  const Name& place = study.prediction->substructure;
  for (const auto& [location, what, why, fix] : error.issues())
    issues.add(place.location, place.path + ": " + what, why, fix);
  throw InvalidInput(issues.issues());
}

/// The prediction beside the reference, where there is one.
PredictionOutcome compared(const Study& study, const StudyResults& results,
                           const std::vector<DrivenQuantity>& predicted) {
  const auto& estimation = results.get<EstimationOutcome>();
  PredictionOutcome outcome{study.prediction->substructure.value, {}, 0.0};
  TruthComparison comparison(estimation.settled, study.sample_rate(), estimation.band);
  for (const auto& [name, quantity, values] : predicted) {
    PointQuantity point{name, quantity, values, {}, {}, {}, {}};
    if (const auto* simulation = results.find<SimulationOutcome>())
      if (const auto* truth = find_quantity(simulation->points, name, quantity)) comparison.compare(point, truth->mean);
    outcome.points.push_back(std::move(point));
  }
  return outcome;
}

void predict(RunContext& context) {
  const Study& study = context.study;
  auto& results = context.results;
  if (study.prediction) {
    const auto& estimation = results.get<EstimationOutcome>();
    const Stopwatch watch;
    auto estimated = estimated_model(context, estimation);
    if (!results.complete()) return;
    const auto model = estimated ? std::make_shared<const CoupledModel>(std::move(*estimated)) : study.model;
    PredictionOutcome outcome =
        compared(study, results, driven_motion(study, model, estimation, context.job.begin("predict")));
    outcome.seconds = watch.seconds();
    results.put(std::move(outcome));
  }
  if (auto found = predicted_modifications(study, results); !found.modifications.empty()) results.put(std::move(found));
}

std::vector<StructuralModificationResult> modifications_of(const StudyResults& results) {
  const auto* outcome = results.find<ModificationsOutcome>();
  return outcome ? outcome->modifications : std::vector<StructuralModificationResult>{};
}

/// What each choice of parameters predicts by itself.
void add_choices(const ModificationsOutcome& outcome, const std::string& modification, Json& summary) {
  for (const auto& [choice, predicted] : outcome.by_choice)
    for (const auto& each : predicted)
      if (each.name == modification)
        summary["by_choice"][choice] = {{"frequencies_hz", numbers(each.frequencies)},
                                        {"frequencies_std_hz", numbers(each.deviations)}};
}

Json prediction_summary(const StudyResults& results) {
  Json summary = Json::object();
  if (const auto* prediction = results.find<PredictionOutcome>()) {
    Json& points = summary[prediction->substructure];
    const RestingPoints resting(prediction->points, results.get<EstimationOutcome>().settled);
    for (const auto& point : prediction->points)
      add_errors(points[point.point.substr(point.point.find('.') + 1)], point, resting);
  }
  for (const auto& each : modifications_of(results)) {
    Json frequencies = Json::array();
    for (const double f : each.frequencies) frequencies.push_back(number(f));
    Json& modification = summary[each.name];
    modification = {{"substructure", each.substructure}, {"frequencies_hz", frequencies}};
    if (each.deviations.size() == 0) continue;
    modification["frequencies_std_hz"] = Json::array();
    for (const double deviation : each.deviations) modification["frequencies_std_hz"].push_back(number(deviation));
    modification["note"] = deviations_leave_out;
    add_choices(results.get<ModificationsOutcome>(), each.name, modification);
  }
  return summary;
}

std::string told(const Study& study, const StudyResults& results) {
  std::string text;
  if (const auto* prediction = results.find<PredictionOutcome>()) {
    const auto& estimation = results.get<EstimationOutcome>();
    if (const auto table = error_table("", study, prediction->points, estimation.settled); !table.rows.empty())
      text += "'" + prediction->substructure + "' driven by its estimated boundary motion, NRMSE" +
              band_words(estimation.band) + "\n" + to_text(table) + "\n";
  }
  if (const auto* outcome = results.find<ModificationsOutcome>()) {
    text +=
        "Natural frequencies after modifications [Hz]\n" + to_text(modification_table(outcome->modifications)) + "\n";
    if (results.has<UpdatingOutcome>()) text += std::string(deviations_leave_out) + "\n";
  }
  return text;
}

std::vector<PlacedSection> sections(const Study& study, const StudyResults& results) {
  std::vector<PlacedSection> all;
  if (const auto* outcome = results.find<ModificationsOutcome>())
    all.push_back({PagePlace::modifications,
                   {"Modifications",
                    std::string("Natural frequencies predicted without further updating. ") +
                        (results.has<UpdatingOutcome>() ? deviations_leave_out : ""),
                    {modification_table(outcome->modifications)}}});
  if (const auto* prediction = results.find<PredictionOutcome>())
    all.push_back({PagePlace::prediction, prediction_section(study, results.get<EstimationOutcome>(), *prediction)});
  return all;
}

}  // namespace

RunStep prediction_step() {
  return {.name = "predict",
          .meaning = "predict the response of a linear substructure, running the steps this needs",
          .asked_for = [](const Study& study) { return study.prediction.has_value() || !study.modifications.empty(); },
          .with = {"estimate"},
          .phases =
              [](const Study& study) {
                return std::vector<PlannedStep>(study.prediction ? 1 : 0, {"predict", 2.0});
              },
          .run = &predict,
          .ran =
              [](const StudyResults& results) {
                return results.has<PredictionOutcome>() || results.has<ModificationsOutcome>();
              },
          .seconds = &seconds_of<PredictionOutcome>,
          .summarise = [](const Study&, const StudyResults& results,
                          Json& summary) { summary["prediction"] = prediction_summary(results); },
          .tell = &told,
          .sections = &sections,
          .visit =
              [](const Study&, const StudyResults& results, SeriesWriter& file) {
                if (const auto* prediction = results.find<PredictionOutcome>())
                  file.write_points("/prediction", prediction->points);
              }};
}

}  // namespace kalfem
