#include "kalfem/casefile/estimation_stage.hpp"

#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/filter_run.hpp"
#include "kalfem/casefile/reported_quantities.hpp"
#include "kalfem/casefile/study_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The record again from the estimated parameters and initial state, without any correction by measurements.
void simulate_open_loop(const Study& study, const ObserverSetup& setup, EstimationStage& stage) {
  const auto& observer = *stage.observer;
  const auto& layout = observer.layout();
  const Index last = stage.result.state.mean.cols() - 1;
  const auto linear = linear_unknowns(observer.options());
  LocallyNonlinearSystem system = linear.empty() ? observer.system()
                                                 : observer.options().system_at(
                                                       stage.result.unknowns.mean.col(last)(linear));
  for (Index i = 0; i < layout.unknowns; ++i)
    for (const auto& target : observer.options().unknowns[static_cast<std::size_t>(i)].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          stage.result.unknowns.mean(i, last);
  const VectorXd start = stage.result.state.mean.col(last).segment(layout.initial_state(), layout.linear);
  const VectorXd states = stage.result.state.mean.col(last).tail(layout.connector_states);

  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : setup.sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
  }
  SimulationOptions options;
  options.integrator = Integrator::exact;
  options.duration = static_cast<double>(last) / study.sample_rate();
  auto reference = simulate_reference(system, study.signals,
                                      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states},
                                      make_outputs(*setup.model, outputs), chains, options,
                                      {.sample_rate = study.sample_rate(), .first_substeps = 1, .max_substeps = 64});
  stage.open_loop = std::move(reference.simulation);
  stage.open_loop_sensors = std::move(reference.sensors);
  const Index tail = std::max<Index>(1, (last + 1) / 20);  // where the structure rests at the end

  for (Index j = 0; j < stage.measurements.values.cols(); ++j) {
    const VectorXd measured = stage.measurements.values.col(j);
    const auto present = measured.array().isNaN();
    const VectorXd end = measured.tail(tail), known = end.array().isNaN().select(0.0, end);
    const double rest = known.sum() / std::max(1.0, static_cast<double>((!end.array().isNaN()).count()));
    const VectorXd error = present.select(0.0, stage.open_loop_sensors.col(j) - measured);
    const VectorXd about_rest = present.select(0.0, measured.array() - rest);
    stage.open_loop_nrmse.push_back(rms(error) / std::max(rms(about_rest), 1e-300));
    stage.open_loop_rest_error.push_back(stage.open_loop_sensors.col(j).tail(tail).mean() - rest);
  }
}

/// Standard deviations of motion change slowly: a hundred times a second will do.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

}  // namespace

EstimationStage estimate_stage(const Study& study, const ObserverSetup& setup, const StudyResults& results,
                               const Progress& progress, std::string& failure) {
  const Stopwatch watch;
  const auto& given = *study.given.estimate;
  const FilterRun run = make_filter_run(study, setup, full_record(study, results));
  EstimationStage stage;
  stage.measurements = run.measurements;
  stage.noise.assign(run.noise.begin(), run.noise.end());
  stage.filter = run.choice.filter;
  stage.filter_reason = run.choice.reason;
  stage.observer = run.choice.observer;
  const auto monitored = reported_quantities(*setup.model);
  const EstimationOptions options{.filter = stage.filter,
                                  .unscented = given.unscented,
                                  .threads = filter_threads(study),
                                  .passes = given.passes,
                                  .state_deviations = false,
                                  .deviation_stride = samples_between_deviations(study.sample_rate()),
                                  .monitored = make_outputs(*setup.model, monitored),
                                  .progress = progress};
  stage.result = estimate(*stage.observer, run.record, options);
  if (stage.result.observer) stage.observer = stage.result.observer;
  if (stage.result.failure)
    failure = "the filter stopped at " + shortest(stage.result.failure->time) + " s: " + stage.result.failure->reason;

  stage.settled = std::min<Index>(static_cast<Index>(std::llround(given.settle * study.sample_rate())),
                                  stage.measurements.samples() - 1);
  stage.band = excitation_band(study.given);
  stage.consistency =
      summarise_consistency(stage.result.nis, stage.result.measured, stage.result.innovation, run.noise, stage.settled);
  for (std::size_t i = 0; i < monitored.size(); ++i) {
    const auto row = static_cast<Index>(i);
    PointQuantity quantity{monitored[i].name,
                           monitored[i].quantity,
                           stage.result.monitored.mean.row(row).transpose(),
                           stage.result.monitored.deviation.row(row).transpose(),
                           {},
                           {},
                           {}};
    if (results.simulation)
      if (const auto* truth = find_quantity(results.simulation->points, quantity.point, quantity.quantity))
        compare(quantity, truth->mean, {stage.settled, study.sample_rate(), stage.band});
    stage.points.push_back(std::move(quantity));
  }
  if (given.estimate_initial_state && !stage.result.failure && !given.local) simulate_open_loop(study, setup, stage);
  stage.seconds = watch.seconds();
  return stage;
}

}  // namespace kalfem
