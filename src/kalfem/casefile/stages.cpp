#include "kalfem/casefile/stages.hpp"

#include "kalfem/base/random.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/estimation_stage.hpp"
#include "kalfem/casefile/field_series.hpp"
#include "kalfem/casefile/initial_state.hpp"
#include "kalfem/casefile/modifications.hpp"
#include "kalfem/casefile/observer_setup.hpp"
#include "kalfem/casefile/prediction_stage.hpp"
#include "kalfem/casefile/reported_quantities.hpp"
#include "kalfem/casefile/substructure_modes.hpp"
#include "kalfem/casefile/updating_stage.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<MeasurementChain> chains_of(const std::vector<StudySensor>& sensors) {
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : sensors) chains.push_back(sensor.chain);
  return chains;
}

/// Adds white noise of each sensor's own stream, so that one sensor more does not change the others.
void add_noise(const Study& study, SimulationStage& stage) {
  const auto& clean = stage.reference.sensors;
  stage.measurements = {study.given.simulate->sample_rate, 0.0, {}, clean};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto column = static_cast<Index>(i);
    const auto& sensor = study.sensors[i];
    stage.noise.push_back(sensor.deviation(rms(clean.col(column))));
    stage.measurements.channels.push_back({sensor.name, sensor.unit});
    RandomStream random(study.given.simulate->seed, sensor.name);
    for (Index k = 0; k < clean.rows(); ++k)
      stage.measurements.values(k, column) += stage.noise.back() * random.normal();
  }
}

SimulationStage simulate_stage(const Study& study, const Progress& progress, std::vector<FieldSeries>& fields,
                               std::string& failure) {
  const auto& given = *study.given.simulate;
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : study.sensors) outputs.push_back(sensor.output);
  const Stopwatch watch;
  SimulationOptions options;
  options.integrator = given.integrator;
  options.duration = given.duration;
  options.hht_alpha = given.hht_alpha;
  options.spectral_radius = given.spectral_radius;
  options.progress = progress;
  options.keep_motion = false;
  const auto reported = reported_quantities(*study.model);
  options.every_sample = make_outputs(*study.model, reported);
  FieldCollector collector(study);
  collector.attach(options);
  SimulationStage stage;
  stage.reference = simulate_reference(study.model->system(), study.signals, initial_state(study, *study.model),
                                       make_outputs(*study.model, outputs), chains_of(study.sensors), options,
                                       {.sample_rate = given.sample_rate,
                                        .first_substeps = given.first_substeps,
                                        .max_substeps = given.max_substeps,
                                        .tolerance = given.tolerance});
  if (stage.reference.simulation.failure)
    failure = "the simulation stopped at " + shortest(stage.reference.simulation.failure->time) +
              " s: " + stage.reference.simulation.failure->reason;
  else if (!stage.reference.converged && !study.sensors.empty())
    failure = "the reference did not converge: halving the step to 1/" + std::to_string(stage.reference.substeps) +
              " of a sample still changes a sensor's record by " + shortest(stage.reference.last_change) +
              " of its rms; raise simulate.max_substeps or simulate.tolerance";
  else
    add_noise(study, stage);
  const auto& values = stage.reference.simulation.every_sample;
  for (std::size_t i = 0; i < reported.size(); ++i)
    stage.points.push_back({reported[i].name, reported[i].quantity, values.col(static_cast<Index>(i)), {}, {}, {}, {}});
  stage.reference.simulation.every_sample.resize(0, 0);
  if (auto series = collector.take()) fields.push_back(std::move(*series));
  stage.seconds = watch.seconds();
  return stage;
}

/// The structure that the updating ended at: the observer's, and the one to predict from.
struct Updated {
  ObserverSetup observer;
  CoupledModel model;
};

Updated updated_structure(const Study& study, const ParameterisedStructure& structure, const UpdatingStage& updating) {
  const Parts parts = structure.at(updating.values).parts;
  IssueList issues;
  ObserverSetup observer = make_observer_setup(study, parts, present_values(*study.updating, updating.values), issues);
  issues.raise();
  return {std::move(observer), couple(parts)};
}

/// The structure as the filter's estimates of its linear unknowns leave it.
CoupledModel estimated_structure(const Study& study, const EstimationStage& estimation) {
  const auto& observer = *estimation.observer;
  const VectorXd last = estimation.result.unknowns.mean.rightCols(1);
  return couple(parts_at(study, study.observer->linear_unknowns, last(linear_unknowns(observer.options()))));
}

/// The last estimates of the filter's unknowns with the structure as the updating finds it.
VectorXd unknowns_at_start(const Study& study, const StudyResults& results) {
  std::string failure;
  const auto before = estimate_stage(study, *study.observer, results, {}, failure);
  return failure.empty() ? VectorXd(before.result.unknowns.mean.rightCols(1)) : VectorXd();
}

}  // namespace

StudyResults run_study(const Study& study, Stage last, const RunOptions& options) {
  const Stopwatch watch;
  StudyResults results;
  const bool updates = last >= Stage::update && study.updating;
  const auto structure = updates ? parameterised_structure(study) : nullptr;
  auto comparisons = updates ? make_comparisons(study, structure) : std::vector<ComparisonResidual>();
  if (updates) predict_modifications(study, std::nullopt);  // what cannot be is found before the work begins
  results.modes = substructure_modes(study, study.given.report.modes);
  if (last >= Stage::simulate && study.given.simulate)
    results.simulation = simulate_stage(study, options.progress, results.fields, results.failure);
  std::optional<Updated> updated;
  if (results.usable() && updates) {
    results.updating = update_stage(study, std::move(comparisons), results, structure, options, results.failure);
    if (study.observer && results.usable()) {
      results.updating->unknowns_before = unknowns_at_start(study, results);
      updated.emplace(updated_structure(study, *structure, *results.updating));
    }
  }
  const bool estimates_linear_part = study.observer && !study.observer->linear_unknowns.empty();
  if (results.usable() && last >= Stage::estimate && study.observer) {
    results.estimation = estimate_stage(study, updated ? updated->observer : *study.observer, results, options.progress,
                                        results.failure);
    if (!updated && !estimates_linear_part)  // else the basis of the pictures is not that of the observer
      if (auto series = estimated_fields(study, *results.estimation)) results.fields.push_back(std::move(*series));
  }
  if (results.usable() && last >= Stage::predict && study.given.predict) {
    const auto estimated =
        estimates_linear_part ? std::optional(estimated_structure(study, *results.estimation)) : std::nullopt;
    const CoupledModel& model = updated ? updated->model : estimated ? *estimated : *study.model;
    results.prediction = predict_stage(study, model, results, options.progress);
  }
  if (results.usable() && last >= Stage::predict)
    results.modifications = predict_modifications(study, results.updating);
  results.total_seconds = watch.seconds();
  return results;
}

void check_updating(const Study& study) {
  if (study.updating) make_comparisons(study, parameterised_structure(study));
  predict_modifications(study, std::nullopt);
}

}  // namespace kalfem
