#include "kalfem/study/filter_run.hpp"

#include "kalfem/study/augmented_model_setup.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "kalfem/records/local_polynomial.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

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

/// Root mean square of the samples that are there.
double rms_of_present(const Eigen::Ref<const VectorXd>& channel) {
  const auto present = channel.array().isFinite();
  const double count = std::max(1.0, static_cast<double>(present.count()));
  return std::sqrt(present.select(channel, 0.0).squaredNorm() / count);
}

/// [r; r'; r''] of the augmented model's inputs at every substep: excitation signals, recorded accelerations in the
/// place of r'', zero for unknown forces.
MatrixXd augmented_model_inputs(const Study& study, const AugmentedModelSetup& setup, const FullRecord& record) {
  const auto& sources = setup.input_sources;
  const auto n_u = static_cast<Index>(sources.size());
  const Index parts = setup.options.substeps, fine = (record.series.samples() - 1) * parts + 1;
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

/// First samples of the record from which the motion at its start is read.
constexpr Index samples_at_start = 4;

/// Prior standard deviation of a sensor's rest position; 0 where it is known.
double rest_deviation(const AugmentedModelOptions& options, std::size_t sensor) {
  for (const auto& unknown : options.unknowns)
    if (std::ranges::find(unknown.sensors, static_cast<Index>(sensor)) != unknown.sensors.end())
      return unknown.deviation;
  return 0.0;
}

/// Displacements and velocities at the first sample, least squares from the displacement sensors, what these see of
/// moving grounds taken off. Displacements are no better known than the rest positions that they are measured from.
/// `inputs`: [r; r'; r''] there.
void set_start_from_record(const AugmentedModelSetup& setup, const TimeSeries& series, const VectorXd& inputs,
                           StatePrior& prior) {
  std::vector<OutputDescription> outputs;
  std::vector<Index> columns;
  std::vector<double> of_rest;
  for (std::size_t i = 0; i < setup.sensors.size(); ++i) {
    const auto& sensor = setup.sensors[i];
    if (sensor.output.quantity != ObservedQuantity::displacement) continue;
    outputs.push_back(sensor.output);
    columns.push_back(series.find(sensor.name));
    of_rest.push_back(rest_deviation(setup.options, i));
  }
  const OutputMap map = make_outputs(*setup.model, outputs);
  const TimeSeries seen{series.sample_rate, series.start, {}, series.values(Eigen::all, columns)};
  const double reach = static_cast<double>(samples_at_start - 1) / series.sample_rate;
  const auto motion = local_motion(seen, 0, {.half_window = reach, .degree = 2});
  const MatrixXd inverse = MatrixXd(map.displacement).completeOrthogonalDecomposition().pseudoInverse();
  const Index n_u = inputs.size() / 3;
  const VectorXd base = map.input_value * inputs.head(n_u), base_velocity = map.input_value * inputs.segment(n_u, n_u);
  prior.mean.displacement = inverse * (motion.position - base);
  prior.mean.velocity = inverse * (motion.velocity - base_velocity);
  const VectorXd rest = VectorXd::Map(of_rest.data(), static_cast<Index>(of_rest.size()));
  prior.displacement_deviation =
      (prior.displacement_deviation.cwiseAbs2() + inverse.cwiseAbs2() * rest.cwiseAbs2()).cwiseSqrt();
}

/// The augmented model's options with what only the record tells: the noise of accelerations that drive it, sensor
/// states. `inputs`: of the augmented model at the first sample.
AugmentedModelOptions completed_options(const Study& study, const AugmentedModelSetup& setup, const FullRecord& record,
                                        const VectorXd& inputs) {
  AugmentedModelOptions options = setup.options;
  for (std::size_t i = 0; i < setup.input_sources.size(); ++i) {
    const std::string& source = setup.input_sources[i];
    if (source.empty() || source.front() != '@') continue;
    const Index channel = record.series.find(source.substr(1));
    // White noise of standard deviation s per sample, held over 1 / f, has the density s / sqrt(f).
    options.process_noise.input[static_cast<Index>(i)] =
        record.noise[static_cast<std::size_t>(channel)] / std::sqrt(record.series.sample_rate);
  }
  double largest = 0.0;
  for (Index j = 0; j < record.series.values.cols(); ++j)
    largest = std::max(largest, rms_of_present(record.series.values.col(j)));
  options.prior.sensor_state_deviation = 0.1 * largest;
  if (study.given.estimate->initial_state_from_record)
    set_start_from_record(setup, record.series, inputs, options.prior);
  return options;
}

/// Noise in per cent of nothing is none, and the filter cannot weigh such a sensor.
void check_noise(const Study& study, const std::vector<double>& noise, const std::string& channel) {
  IssueList issues;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const auto& sensor = study.sensors[i];
    const auto& given = study.given.sensors[i].second.noise;
    if (sensor.relative_noise && sensor.noise > 0.0 && noise[i] == 0.0)
      issues.add(given.location,
                 given.path + ": the noise is " + shortest(100.0 * sensor.noise) + " % of the channel's rms, but " +
                     channel + " is 0 throughout",
                 "per cent of nothing is no noise",
                 "give the noise in " + sensor.unit + ", or take the sensor out if nothing moves there");
  }
  issues.raise();
}

}  // namespace

FullRecord full_record(const Study& study, const StudyResults& results) {
  if (results.simulation) {
    check_noise(study, results.simulation->noise, "the simulated channel");
    return {results.simulation->measurements, results.simulation->noise};
  }
  FullRecord record{study.record->series, {}};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    record.noise.push_back(study.sensors[i].deviation(rms_of_present(record.series.values.col(static_cast<Index>(i)))));
    record.series.channels[i].unit = study.sensors[i].unit;
  }
  check_noise(study, record.noise, "its channel");
  return record;
}

namespace {

SourceLocation location_of_sensor(const Study& study, Index column) {
  return std::visit([](const auto& observed) { return observed.points.location; },
                    study.given.sensors[static_cast<std::size_t>(column)].second.observed);
}

void check_start_from_record(const Study& study, IssueList& issues) {
  const TimeSeries& series = study.record->series;
  for (const auto& sensor : study.augmented_model->sensors) {
    const Index column = series.find(sensor.name);
    if (sensor.output.quantity != ObservedQuantity::displacement ||
        series.values.col(column).head(std::min(samples_at_start, series.samples())).allFinite())
      continue;
    issues.add(location_of_sensor(study, column),
               "sensors." + sensor.name + ": one of the first " + std::to_string(samples_at_start) +
                   " samples is missing, from " + shortest(series.start) + " s on",
               "estimate.initial_state_from_record reads displacement and velocity there",
               "let the case begin later (record.start), or give estimate.initial_state");
  }
}

void check_driving_channels(const Study& study, IssueList& issues) {
  const TimeSeries& series = study.record->series;
  for (const auto& source : study.augmented_model->input_sources) {
    const Index column = source.starts_with('@') ? series.find(source.substr(1)) : -1;
    if (column < 0) continue;
    const VectorXd samples = series.values.col(column);
    const auto gap = std::ranges::find_if(samples, [](double value) { return !std::isfinite(value); });
    if (gap == samples.end()) continue;
    issues.add(location_of_sensor(study, column),
               "sensors." + source.substr(1) + " drives an interface of the filter's model and misses the sample at " +
                   shortest(series.time(gap - samples.begin())) + " s",
               "the motion of the interface is not known there",
               "use a part of the record without gaps in this channel (record.start, record.end)");
  }
}

/// `first_inputs`: of the augmented model at the first sample.
FilterChoice choose(const Study& study, const AugmentedModelSetup& setup, const FullRecord& record,
                    const VectorXd& first_inputs, std::optional<StateCoordinates> coordinates) {
  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : setup.sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
  }
  AugmentedModelOptions options = completed_options(study, setup, record, first_inputs);
  options.system_at = system_of_linear_unknowns(study, setup);
  const OutputMap map = make_outputs(*setup.model, outputs);
  if (!coordinates)
    return choose_filter(study.given.estimate->filter, setup.model->system(), map, chains, std::move(options));
  FilterChoice choice;
  options.coordinates = *coordinates;
  choice.augmented_model = std::make_shared<const AugmentedModel>(setup.model->system(), map, chains, options);
  return choice;
}

/// The first samples of the record; zeros where it is yet to be simulated.
FullRecord first_samples(const Study& study) {
  constexpr Index most = 100;
  const auto sensors = static_cast<Index>(study.sensors.size());
  if (study.record) {
    FullRecord record = full_record(study, {});
    auto& values = record.series.values;
    values = MatrixXd(values.topRows(std::min(most, values.rows())));
    return record;
  }
  const auto& simulated = *study.given.simulate;
  const auto samples = std::min(most, static_cast<Index>(simulated.duration * simulated.sample_rate) + 1);
  FullRecord record{{simulated.sample_rate, 0.0, {}, MatrixXd::Zero(samples, sensors)}, {}};
  for (const auto& sensor : study.sensors) {
    record.series.channels.push_back({sensor.name, sensor.unit});
    record.noise.push_back(1.0);
  }
  return record;
}

}  // namespace

FilterRun make_filter_run(const Study& study, const AugmentedModelSetup& setup, const FullRecord& record,
                          std::optional<StateCoordinates> coordinates) {
  FilterRun run;
  run.noise.resize(static_cast<Index>(setup.sensors.size()));
  for (std::size_t i = 0; i < setup.sensors.size(); ++i)
    run.noise[static_cast<Index>(i)] =
        record.noise[static_cast<std::size_t>(record.series.find(setup.sensors[i].name))];
  run.measurements = channels_of(record.series, setup.sensors);
  const MatrixXd inputs = augmented_model_inputs(study, setup, record);
  run.choice = choose(study, setup, record, inputs.col(0), coordinates);
  MatrixXd used = run.measurements.values.transpose();
  if (study.record)
    used.rightCols(used.cols() - study.record->used).setConstant(std::numeric_limits<double>::quiet_NaN());
  run.record = {used, inputs, run.noise.cwiseAbs2().asDiagonal()};
  return run;
}

void check_needed_samples(const Study& study, IssueList& issues) {
  if (!study.record || !study.augmented_model) return;
  if (study.given.estimate->initial_state_from_record) check_start_from_record(study, issues);
  check_driving_channels(study, issues);
}

void check_filter(const Study& study) {
  const auto& given = *study.given.estimate;
  const FullRecord record = first_samples(study);
  const VectorXd inputs = augmented_model_inputs(study, *study.augmented_model, record).col(0);
  const FilterChoice choice = choose(study, *study.augmented_model, record, inputs, std::nullopt);
  validate(*choice.augmented_model, {.filter = choice.filter, .unscented = given.unscented, .passes = given.passes})
      .raise();
}

int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int filter_threads(const Study& study) {
  const int given = study.given.estimate->threads;
  return given > 0 ? given : processors();
}

}  // namespace kalfem
