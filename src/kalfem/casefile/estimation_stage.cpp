#include "kalfem/casefile/estimation_stage.hpp"

#include <cmath>
#include <limits>
#include <thread>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/reported_quantities.hpp"
#include "kalfem/casefile/study_elements.hpp"
#include "kalfem/estimation/filter_choice.hpp"
#include "kalfem/formats/local_polynomial.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Everything that the case's record holds, with the noise of each channel.
struct FullRecord {
  TimeSeries series;
  std::vector<double> noise;
};

FullRecord full_record(const Study& study, const StudyResults& results) {
  if (results.simulation) return {results.simulation->measurements, results.simulation->noise};
  FullRecord record{study.record->series, {}};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const VectorXd channel = record.series.values.col(static_cast<Index>(i));
    const VectorXd known = channel.array().isNaN().select(0.0, channel);
    record.noise.push_back(study.sensors[i].deviation(rms(known)));
    record.series.channels[i].unit = study.sensors[i].unit;
  }
  return record;
}

TimeSeries channels_of(const TimeSeries& series, const std::vector<StudySensor>& sensors) {
  TimeSeries selected{
      series.sample_rate, series.start, {}, MatrixXd(series.samples(), static_cast<Index>(sensors.size()))};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const Index column = series.find(sensors[i].name);
    selected.channels.push_back(series.channels[static_cast<std::size_t>(column)]);
    selected.values.col(static_cast<Index>(i)) = series.values.col(column);
  }
  return selected;
}

/// Samples with so many equal parts between each two, straight lines between them.
VectorXd interpolated(const VectorXd& samples, Index parts) {
  VectorXd fine((samples.size() - 1) * parts + 1);
  for (Index k = 0; k < fine.size(); ++k) {
    const Index before = std::min(k / parts, samples.size() - 2);
    const double weight = static_cast<double>(k - before * parts) / static_cast<double>(parts);
    fine[k] = (1.0 - weight) * samples[before] + weight * samples[before + 1];
  }
  return fine;
}

/// [r; r'; r''] of the observer's inputs at every substep: excitation signals, recorded accelerations in the place of
/// r'', zero for unknown forces.
MatrixXd observer_inputs(const Study& study, const FullRecord& record) {
  const auto& sources = study.observer->input_sources;
  const auto n_u = static_cast<Index>(sources.size());
  const Index parts = study.observer->options.substeps, fine = (record.series.samples() - 1) * parts + 1;
  MatrixXd inputs = MatrixXd::Zero(3 * n_u, fine);
  for (Index i = 0; i < n_u; ++i) {
    const std::string& source = sources[static_cast<std::size_t>(i)];
    if (source.empty()) continue;
    if (source.front() == '@') {
      inputs.row(2 * n_u + i) =
          interpolated(record.series.values.col(record.series.find(source.substr(1))), parts).transpose();
      continue;
    }
    for (std::size_t j = 0; j < study.parts.inputs.size(); ++j) {
      if (study.parts.inputs[j].name != source) continue;
      const double step = 1.0 / (study.sample_rate() * static_cast<double>(parts));
      const auto sampled = study.signals[j]->sample(record.series.start, step, fine);
      for (Index derivative = 0; derivative < 3; ++derivative)
        inputs.row(derivative * n_u + i) = sampled.col(derivative).matrix().transpose();
    }
  }
  return inputs;
}

/// Displacements and velocities at the first sample, least squares from the displacement sensors.
void set_start_from_record(const Study& study, const TimeSeries& series, InitialState& start) {
  std::vector<OutputDescription> outputs;
  std::vector<Index> columns;
  for (const auto& sensor : study.observer->sensors) {
    if (sensor.output.quantity != ObservedQuantity::displacement) continue;
    outputs.push_back(sensor.output);
    columns.push_back(series.find(sensor.name));
  }
  const OutputMap map = make_outputs(*study.observer->model, outputs);
  const auto motion = local_motion(series, 0, {.half_window = 3.0 / series.sample_rate, .degree = 2});
  const auto inverse = MatrixXd(map.displacement).completeOrthogonalDecomposition();
  start.displacement = inverse.solve(motion.position(columns).eval());
  start.velocity = inverse.solve(motion.velocity(columns).eval());
}

/// The observer's options with what only the record tells: the noise of accelerations that drive it, sensor states.
ObserverOptions completed_options(const Study& study, const FullRecord& record) {
  ObserverOptions options = study.observer->options;
  for (std::size_t i = 0; i < study.observer->input_sources.size(); ++i) {
    const std::string& source = study.observer->input_sources[i];
    if (source.empty() || source.front() != '@') continue;
    const Index channel = record.series.find(source.substr(1));
    // White noise of standard deviation s per sample, held over 1 / f, has the density s / sqrt(f).
    options.process_noise.input[static_cast<Index>(i)] =
        record.noise[static_cast<std::size_t>(channel)] / std::sqrt(record.series.sample_rate);
  }
  double largest = 0.0;
  for (Index j = 0; j < record.series.values.cols(); ++j) {
    const VectorXd channel = record.series.values.col(j);
    largest = std::max(largest, rms(channel.array().isNaN().select(0.0, channel)));
  }
  options.prior.sensor_state_deviation = 0.1 * largest;
  if (study.given.estimate->initial_state_from_record) set_start_from_record(study, record.series, options.prior.mean);

  return options;
}

/// The record again from the estimated parameters and initial state, without any correction by measurements.
void simulate_open_loop(const Study& study, EstimationStage& stage) {
  const auto& observer = *stage.observer;
  const auto& layout = observer.layout();
  const Index last = stage.result.state.mean.cols() - 1;
  LocallyNonlinearSystem system = observer.system();
  for (Index i = 0; i < layout.unknowns; ++i)
    for (const auto& target : observer.options().unknowns[static_cast<std::size_t>(i)].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          stage.result.unknowns.mean(i, last);
  const VectorXd start = stage.result.state.mean.col(last).segment(layout.initial_state(), layout.linear);
  const VectorXd states = stage.result.state.mean.col(last).tail(layout.connector_states);

  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : study.observer->sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
  }
  SimulationOptions options;
  options.integrator = Integrator::exact;
  options.duration = static_cast<double>(last) / study.sample_rate();
  auto reference = simulate_reference(system, study.signals,
                                      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states},
                                      make_outputs(*study.observer->model, outputs), chains, options,
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

int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace

EstimationStage estimate_stage(const Study& study, const StudyResults& results, const Progress& progress,
                               std::string& failure) {
  const Stopwatch watch;
  const auto& given = *study.given.estimate;
  const auto& setup = *study.observer;
  const FullRecord record = full_record(study, results);
  EstimationStage stage;
  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : setup.sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
    stage.noise.push_back(record.noise[static_cast<std::size_t>(record.series.find(sensor.name))]);
  }
  stage.measurements = channels_of(record.series, setup.sensors);
  const auto choice = choose_filter(given.filter, setup.model->system(), make_outputs(*setup.model, outputs), chains,
                                    completed_options(study, record));
  stage.filter = choice.filter;
  stage.filter_reason = choice.reason;
  stage.observer = choice.observer;
  const VectorXd noise = Eigen::Map<const VectorXd>(stage.noise.data(), static_cast<Index>(stage.noise.size()));
  const auto monitored = reported_quantities(*setup.model);
  const EstimationOptions options{.filter = stage.filter,
                                  .unscented = given.unscented,
                                  .threads = given.threads > 0 ? given.threads : processors(),
                                  .passes = given.passes,
                                  .state_deviations = false,
                                  .deviation_stride = samples_between_deviations(study.sample_rate()),
                                  .monitored = make_outputs(*setup.model, monitored),
                                  .progress = progress};
  MatrixXd used = stage.measurements.values.transpose();
  if (study.record)
    used.rightCols(used.cols() - study.record->used).setConstant(std::numeric_limits<double>::quiet_NaN());
  const Record observed{used, observer_inputs(study, record), noise.cwiseAbs2().asDiagonal()};
  stage.result = estimate(*stage.observer, observed, options);
  if (stage.result.failure)
    failure = "the filter stopped at " + shortest(stage.result.failure->time) + " s: " + stage.result.failure->reason;

  stage.settled = std::min<Index>(static_cast<Index>(std::llround(given.settle * study.sample_rate())),
                                  stage.measurements.samples() - 1);
  stage.band = excitation_band(study.given);
  stage.consistency =
      summarise_consistency(stage.result.nis, stage.result.measured, stage.result.innovation, noise, stage.settled);
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
  if (given.estimate_initial_state && !stage.result.failure && !given.local) simulate_open_loop(study, stage);
  stage.seconds = watch.seconds();
  return stage;
}

}  // namespace kalfem
