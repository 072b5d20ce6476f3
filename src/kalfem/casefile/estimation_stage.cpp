#include "kalfem/casefile/estimation_stage.hpp"

#include <cmath>
#include <limits>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/filter_run.hpp"
#include "kalfem/casefile/reported_quantities.hpp"
#include "kalfem/casefile/study_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The observer's system at the estimated parameters.
LocallyNonlinearSystem estimated_system(const EstimationStage& stage) {
  const auto& options = stage.observer->options();
  const VectorXd estimates = stage.result.unknowns.mean.rightCols(1);
  const auto linear = linear_unknowns(options);
  LocallyNonlinearSystem system = linear.empty() ? stage.observer->system() : options.system_at(estimates(linear));
  const auto& unknowns = options.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          estimates[static_cast<Index>(i)];
  return system;
}

/// The case's excitation with the record's first sample at time 0.
std::vector<SignalPtr> signals_from(const Study& study, double start) {
  std::vector<SignalPtr> signals;
  for (const auto& signal : study.signals) signals.push_back(delayed(signal, -start));
  return signals;
}

/// The record again from the estimated parameters and initial state, without any correction by measurements. What the
/// sensors show beside the motion is added.
Reference simulate_record_again(const Study& study, const ObserverSetup& setup, const EstimationStage& stage) {
  const auto& layout = stage.observer->layout();
  const Index last = stage.result.state.mean.cols() - 1;
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
  Reference reference = simulate_reference(
      estimated_system(stage), signals_from(study, stage.measurements.start),
      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states}, make_outputs(*setup.model, outputs),
      chains, options, {.sample_rate = study.sample_rate(), .first_substeps = 1, .max_substeps = 64});
  if (reference.sensors.size() == 0) return reference;
  const auto& unknowns = stage.observer->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors)
      reference.sensors.col(sensor).array() += stage.result.unknowns.mean(static_cast<Index>(i), last);
  return reference;
}

/// A simulation that is so many times as large as the record has left it for good.
constexpr double diverged = 1e6;

/// Why the simulation is no comparison, in words; empty: it is one.
std::string failure_of(const Reference& reference, const TimeSeries& measured) {
  if (const auto& failure = reference.simulation.failure)
    return "the simulation from the estimates stopped at " + shortest(measured.start + failure->time) +
           " s: " + failure->reason;
  for (Index j = 0; j < reference.sensors.cols(); ++j) {
    const double simulated = reference.sensors.col(j).cwiseAbs().maxCoeff();
    const auto record = measured.values.col(j).array();
    const double recorded = record.isFinite().select(record.abs(), 0.0).maxCoeff();
    if (!reference.sensors.col(j).allFinite() || simulated > diverged * std::max(recorded, 1e-300))
      return "the simulation from the estimates grows beyond a million times the record of '" +
             measured.channels[static_cast<std::size_t>(j)].name + "': the estimated structure is unstable";
  }
  return "";
}

void compare_open_loop(const MatrixXd& simulated, EstimationStage& stage) {
  const Index samples = stage.measurements.samples();
  const Index tail = std::max<Index>(1, samples / 20);  // where the structure rests at the end
  for (Index j = 0; j < simulated.cols(); ++j) {
    const VectorXd measured = stage.measurements.values.col(j);
    const auto missing = measured.array().isNaN();
    const VectorXd end = measured.tail(tail), known = end.array().isNaN().select(0.0, end);
    const double rest = known.sum() / std::max(1.0, static_cast<double>((!end.array().isNaN()).count()));
    const VectorXd error = missing.select(0.0, simulated.col(j) - measured);
    const VectorXd about_rest = missing.select(0.0, measured.array() - rest);
    const double scale = rms(about_rest);
    stage.open_loop_nrmse.push_back(scale > 0.0 ? rms(error) / scale : std::numeric_limits<double>::infinity());
    stage.open_loop_rest_error.push_back(simulated.col(j).tail(tail).mean() - rest);
  }
}

/// Compares the record with its simulation. That this diverges is an outcome: the estimates are then no model.
void simulate_open_loop(const Study& study, const ObserverSetup& setup, EstimationStage& stage) {
  Reference reference = simulate_record_again(study, setup, stage);
  stage.open_loop_failure = failure_of(reference, stage.measurements);
  if (!stage.open_loop_failure.empty()) return;
  stage.open_loop = std::move(reference.simulation);
  stage.open_loop_sensors = std::move(reference.sensors);
  compare_open_loop(stage.open_loop_sensors, stage);
}

/// Standard deviations of motion change slowly: a hundred times a second will do.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

/// Modal coordinates of close poles are an ill-conditioned basis: the covariance may lose its sign there and keep it in
/// physical coordinates, where a step costs more.
bool loses_sign_in_modal_coordinates(const EstimationResult& result, const Observer& observer) {
  return result.failure && result.failure->outcome == FilterOutcome::covariance_not_positive_definite &&
         observer.options().coordinates == StateCoordinates::modal;
}

}  // namespace

EstimationStage estimate_stage(const Study& study, const ObserverSetup& setup, const StudyResults& results,
                               const Progress& progress, std::string& failure) {
  const Stopwatch watch;
  const auto& given = *study.given.estimate;
  const FullRecord record = full_record(study, results);
  FilterRun run = make_filter_run(study, setup, record);
  EstimationStage stage;
  stage.measurements = run.measurements;
  stage.noise.assign(run.noise.begin(), run.noise.end());
  const auto monitored = reported_quantities(*setup.model);
  const EstimationOptions options{.filter = run.choice.filter,
                                  .unscented = given.unscented,
                                  .threads = filter_threads(study),
                                  .passes = given.passes,
                                  .state_deviations = false,
                                  .deviation_stride = samples_between_deviations(study.sample_rate()),
                                  .monitored = make_outputs(*setup.model, monitored),
                                  .progress = progress};
  stage.result = estimate(*run.choice.observer, run.record, options);
  if (loses_sign_in_modal_coordinates(stage.result, *run.choice.observer)) {
    const std::string reason = run.choice.reason;
    run = make_filter_run(study, setup, record, StateCoordinates::physical);
    run.choice.filter = options.filter;
    run.choice.reason = reason + "; in physical coordinates, as rounding in modal ones cost the covariance its sign";
    stage.result = estimate(*run.choice.observer, run.record, options);
  }
  stage.filter = run.choice.filter;
  stage.filter_reason = run.choice.reason;
  stage.observer = run.choice.observer;
  if (stage.result.observer) stage.observer = stage.result.observer;
  if (stage.result.failure)
    failure = "the filter stopped at " + shortest(stage.measurements.start + stage.result.failure->time) +
              " s: " + stage.result.failure->reason;

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
