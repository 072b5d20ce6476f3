// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/filter_run.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <thread>

#include "kalfem/base/parallel.hpp"
#include "kalfem/records/isolated_values.hpp"
#include "kalfem/records/local_polynomial.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<std::string> names_of(const std::vector<Sensor>& sensors) {
  std::vector<std::string> names;
  for (const auto& sensor : sensors) names.push_back(sensor.name);
  return names;
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

/// Whether a sensor drives the model in place of an excitation.
bool is_sensor(const std::string& source) { return !source.empty() && source.front() == '@'; }

/// [r; r'; r''] of the augmented model's inputs at every substep: excitation signals, recorded accelerations in the
/// place of r'', zero for unknown forces.
MatrixXd inputs_of(const EstimationProblem& problem, const AugmentedModelSetup& setup, const Record& record) {
  const auto& sources = setup.input_sources;
  const auto n_u = static_cast<Index>(sources.size());
  const Index parts = setup.options.instants(), fine = (record.samples() - 1) * parts + 1;
  MatrixXd inputs = MatrixXd::Zero(3 * n_u, fine);
  for (Index i = 0; i < n_u; ++i) {
    const std::string& source = sources[static_cast<std::size_t>(i)];
    if (source.empty()) continue;
    if (is_sensor(source)) {
      inputs.row(2 * n_u + i) =
          interpolated(record.values.row(record.find(source.substr(1))).transpose(), parts).transpose();
      continue;
    }
    for (std::size_t j = 0; j < problem.structure->parts.inputs.size(); ++j) {
      if (problem.structure->parts.inputs[j].name != source) continue;
      const double step = 1.0 / (problem.sample_rate * static_cast<double>(parts));
      const auto sampled = problem.structure->signals[j]->sample(record.start, step, fine);
      for (Index derivative = 0; derivative < 3; ++derivative)
        inputs.row(derivative * n_u + i) = sampled.col(derivative).matrix().transpose();
    }
  }
  return inputs;
}

/// The sensors' channels. The filter learns from their samples as long as samples determine the inputs between them.
Record channels_of_sensors(const EstimationProblem& problem, const AugmentedModelSetup& setup, const Record& record) {
  Record measured = select_channels(record, names_of(setup.sensors));
  const auto& parts = problem.structure->parts;
  double until = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < parts.inputs.size(); ++j)
    if (std::ranges::find(setup.input_sources, parts.inputs[j].name) != setup.input_sources.end())
      until = std::min(until, problem.structure->signals[j]->determined_until());
  Index used = measured.samples_used();
  while (used > 0 && measured.time(used - 1) > until) --used;
  if (used < measured.samples_used()) measured.used = used;
  return measured;
}

/// Prior standard deviation of a sensor's rest position; 0 where it is known.
double rest_deviation(const AugmentedModelOptions& options, std::size_t sensor) {
  for (const auto& unknown : options.unknowns)
    if (std::ranges::find(unknown.sensors, static_cast<Index>(sensor)) != unknown.sensors.end())
      return unknown.deviation;
  return 0.0;
}

/// The first samples without spikes: so many that each channel has samples_at_start.
MatrixXd first_values(const MatrixXd& values) {
  const MatrixXd kept = without_isolated_values(values);
  const auto fewest = [&](Index count) { return kept.leftCols(count).array().isFinite().rowwise().count().minCoeff(); };
  Index count = std::min(samples_at_start, kept.cols());
  while (kept.rows() > 0 && count < kept.cols() && fewest(count) < samples_at_start) ++count;
  return kept.leftCols(count);
}

/// Displacements and velocities at the first sample, least squares from the displacement sensors, what these see of
/// moving grounds taken off. Displacements are no better known than the rest positions that they are measured from.
/// `inputs`: [r; r'; r''] there.
void set_start_from_record(const AugmentedModelSetup& setup, const Record& record, const VectorXd& inputs,
                           StatePrior& prior) {
  std::vector<OutputDescription> outputs;
  std::vector<Index> rows;
  std::vector<double> of_rest;
  for (std::size_t i = 0; i < setup.sensors.size(); ++i) {
    const auto& sensor = setup.sensors[i];
    if (sensor.output.quantity != ObservedQuantity::displacement) continue;
    outputs.push_back(sensor.output);
    rows.push_back(record.find(sensor.name));
    of_rest.push_back(rest_deviation(setup.options, i));
  }
  const OutputMap map = make_outputs(*setup.model, outputs);
  const Record seen{record.sample_rate, record.start, {}, first_values(record.values(rows, Eigen::all))};
  const double reach = static_cast<double>(seen.samples() - 1) / record.sample_rate;
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

/// The noise of recorded accelerations that drive the model is process noise.
void set_noise_of_drives(const AugmentedModelSetup& setup, const Record& record, ProcessNoise& noise) {
  for (std::size_t i = 0; i < setup.input_sources.size(); ++i) {
    const std::string& source = setup.input_sources[i];
    if (!is_sensor(source)) continue;
    const auto channel = static_cast<std::size_t>(record.find(source.substr(1)));
    // White noise of standard deviation s per sample, held over 1 / f, has the density s / sqrt(f).
    noise.input[static_cast<Index>(i)] = record.channels[channel].noise / std::sqrt(record.sample_rate);
  }
}

/// The augmented model's options with what only the record tells: the noise of accelerations that drive it, sensor
/// states, the size of a motion that is there at the first sample. `inputs`: of the augmented model at the samples.
AugmentedModelOptions completed_options(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                        const Record& record, const MatrixXd& inputs, bool moving) {
  AugmentedModelOptions options = setup.options;
  set_noise_of_drives(setup, record, options.process_noise);
  double largest = 0.0;
  for (Index j = 0; j < record.values.rows(); ++j)
    largest = std::max(largest, rms_of_present(record.values.row(j).transpose()));
  options.prior.sensor_state_deviation = moving ? largest : 0.1 * largest;
  if (problem.settings.initial_state_from_record) set_start_from_record(setup, record, inputs.col(0), options.prior);
  if (moving) set_moving_start(setup, record, inputs, options.prior);
  return options;
}

/// The sensors of a filter's model.
struct SensorRows {
  explicit SensorRows(const AugmentedModelSetup& setup) {
    std::vector<OutputDescription> outputs;
    for (const auto& sensor : setup.sensors) {
      outputs.push_back(sensor.output);
      chains.push_back(sensor.chain);
    }
    map = make_outputs(*setup.model, outputs);
  }
  OutputMap map;
  std::vector<MeasurementChain> chains;
};

/// `inputs`: of the augmented model at the samples.
FilterChoice choose(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                    const MatrixXd& inputs, bool moving, std::optional<StateCoordinates> coordinates) {
  const SensorRows sensors(setup);
  AugmentedModelOptions options = completed_options(*problem, setup, record, inputs, moving);
  options.system_at = system_of_linear_unknowns(problem, setup);
  if (!coordinates)
    return choose_filter(problem->settings.filter, setup.model->system(), sensors.map, sensors.chains,
                         std::move(options));
  FilterChoice choice;
  options.coordinates = *coordinates;
  choice.augmented_model =
      std::make_shared<const AugmentedModel>(setup.model->system(), sensors.map, sensors.chains, options);
  return choice;
}

/// Of the prior's displacements and velocities, at a typical point.
void set_largest_deviations(const CoupledModel& model, FilterRun& run) {
  const auto& covariance = run.choice.augmented_model->options().prior.motion_covariance;
  const Index n = model.system().size();
  if (covariance.size() == 0) return;
  const VectorXd deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd scale = model.coordinate_scale().cwiseAbs().cwiseMax(1e-300);
  run.start.displacement = deviation.head(n).cwiseQuotient(scale).maxCoeff();
  run.start.velocity = deviation.tail(n).cwiseQuotient(scale).maxCoeff();
}

std::string four_digits(double value) {
  std::ostringstream text;
  text << std::setprecision(4) << value;
  return text.str();
}

/// Whether the structure moves at the first sample, as far as is known without the samples.
std::optional<RecordStart> known_start(const EstimationSettings& settings, const AugmentedModelSetup& setup,
                                       const Record& record) {
  if (setup.model->system().size() == 0) return RecordStart{.reason = "all of its motion is imposed"};
  if (states_initial_motion(settings)) return RecordStart{.reason = "the initial state is as stated"};
  if (record.start > 0.0 && record.samples() > 1)
    return RecordStart{.moving = true, .reason = "the record starts at " + four_digits(record.start) + " s"};
  const std::string rest = "the structure is at rest at the first sample";
  if (setup.starts_at_rest && *setup.starts_at_rest) return RecordStart{.reason = rest};
  if (setup.starts_at_rest) return RecordStart{.moving = true, .reason = "its first samples are not those of rest"};
  return std::nullopt;
}

/// The filter's model with the prior that the record's start asks for.
void choose_with_start(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                       std::optional<StateCoordinates> coordinates, FilterRun& run) {
  const auto parts = static_cast<Index>(setup.options.instants());
  const MatrixXd inputs = run.input.inputs(Eigen::all, Eigen::seq(0, Eigen::last, parts));
  const auto choose_for = [&](const RecordStart& start) {
    run.start = start;
    run.choice = choose(problem, setup, record, inputs, start.moving, coordinates);
    if (start.moving) set_largest_deviations(*setup.model, run);
  };
  if (const auto known = known_start(problem->settings, setup, record)) return choose_for(*known);
  choose_for({.reason = "the structure is at rest at the first sample"});
  const EstimationOptions options{.filter = run.choice.filter, .unscented = problem->settings.unscented};
  const RecordStart start = start_by_first_samples(*run.choice.augmented_model, run.input, options);
  run.start = start;
  if (start.moving) choose_for(start);
}

FilterAttempt attempt_of(const FilteredRecord& filtered) {
  return {filtered.run.choice.filter, filtered.run.choice.augmented_model->options().coordinates,
          filtered.result.failure};
}

/// The choice of `first` in another form, and why.
std::string reason_for(const FilterAttempt& attempt, const FilterAttempt& failed) {
  if (attempt.filter == failed.filter)
    return "in physical coordinates, because rounding errors in modal ones made the covariance indefinite";
  return "with the covariance carried as a triangular factor, because rounding errors made it indefinite";
}

/// The same record through another form of the filter.
FilteredRecord run_again(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                         EstimationOptions options, const FilterAttempt& attempt) {
  FilteredRecord again{make_filter_run(problem, setup, record, attempt.coordinates), {}, {}};
  again.run.choice.filter = options.filter = attempt.filter;
  again.result = estimate(*again.run.choice.augmented_model, again.run.input, options);
  return again;
}

/// Whether the filter that would be chosen runs over the record, which costs less than the one that was asked for; the
/// remedy says so.
void try_chosen_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                       const EstimationOptions& options, FilteredRecord& failed) {
  auto chosen = std::make_shared<EstimationProblem>(*problem);
  chosen->settings.filter.reset();
  EstimationOptions silent = options;
  silent.monitored = {};
  silent.keep_unknowns = false;
  const FilteredRecord other = run_filter(chosen, setup, record, silent);
  failed.attempts.insert(failed.attempts.end(), other.attempts.begin(), other.attempts.end());
  if (other.result.failure) return;
  std::string& remedy = failed.result.failure->remedy;
  remedy = "use filter: auto, which runs to the end of this record" + (remedy.empty() ? "" : ", or " + remedy);
}

}  // namespace

FilterRun make_filter_run(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                          std::optional<StateCoordinates> coordinates) {
  FilterRun run;
  run.input.measured = channels_of_sensors(*problem, setup, record);
  run.input.inputs = inputs_of(*problem, setup, record);
  run.input.noise = run.input.measured.noise().cwiseAbs2().asDiagonal();
  choose_with_start(problem, setup, record, coordinates, run);
  return run;
}

FilterRun make_filter_run_like(const FilterRun& first, const EstimationProblemPtr& problem,
                               const AugmentedModelSetup& setup, const Record& record,
                               std::optional<StateCoordinates> coordinates) {
  FilterRun run{first.choice, {}, first.start};
  run.input.measured = channels_of_sensors(*problem, setup, record);
  const bool driven_by_sensors = std::ranges::any_of(setup.input_sources, is_sensor);
  run.input.inputs = driven_by_sensors ? inputs_of(*problem, setup, record) : first.input.inputs;
  run.input.noise = run.input.measured.noise().cwiseAbs2().asDiagonal();
  run.choice.augmented_model = augmented_model_like(first, problem, setup, record, coordinates);
  return run;
}

std::shared_ptr<const AugmentedModel> augmented_model_like(const FilterRun& first, const EstimationProblemPtr& problem,
                                                           const AugmentedModelSetup& setup, const Record& record,
                                                           std::optional<StateCoordinates> coordinates) {
  const auto& first_options = first.choice.augmented_model->options();
  AugmentedModelOptions options = setup.options;
  options.substeps = first_options.substeps;
  options.step_order = first_options.step_order;
  options.coordinates = coordinates.value_or(first_options.coordinates);
  options.prior = first_options.prior;
  options.system_at = system_of_linear_unknowns(problem, setup);
  set_noise_of_drives(setup, record, options.process_noise);
  const SensorRows sensors(setup);
  return std::make_shared<const AugmentedModel>(setup.model->system(), sensors.map, sensors.chains, std::move(options));
}

std::vector<FilterAttempt> attempts_after(const FilterAttempt& failed, bool kind_is_given) {
  std::vector<FilterAttempt> next;
  const bool tiled = failed.filter == FilterKind::partially_linear;
  const bool sign_lost =
      failed.failure && (failed.failure->outcome == FilterOutcome::covariance_not_positive_definite ||
                         failed.failure->outcome == FilterOutcome::innovation_not_positive_definite);
  if (!sign_lost || !tiled) return next;
  if (failed.coordinates == StateCoordinates::modal)
    next.push_back({FilterKind::partially_linear, StateCoordinates::physical, {}});
  if (!kind_is_given) next.push_back({FilterKind::partially_linear_square_root, StateCoordinates::physical, {}});
  return next;
}

FilteredRecord run_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                          EstimationOptions options) {
  const auto given = problem->settings.filter;
  FilteredRecord first{make_filter_run(problem, setup, record), {}, {}};
  options.filter = first.run.choice.filter;
  first.result = estimate(*first.run.choice.augmented_model, first.run.input, options);
  first.attempts = {attempt_of(first)};
  if (!first.result.failure) return first;
  const FilterAttempt failed = first.attempts.front();
  for (const auto& attempt : attempts_after(failed, given.has_value())) {
    FilteredRecord again = run_again(problem, setup, record, options, attempt);
    first.attempts.push_back(attempt_of(again));
    if (again.result.failure) continue;
    again.attempts = first.attempts;
    again.run.choice.reason = first.run.choice.reason + "; " + reason_for(attempt, failed);
    return again;
  }
  if (given && given != FilterKind::partially_linear) try_chosen_filter(problem, setup, record, options, first);
  return first;
}

double steps_of_run(const EstimationProblem& problem, const Record& record, int substeps) {
  const double linear_parts = substeps * problem.settings.step_order / 2.0;  // a step of order 4 costs two of order 2
  return static_cast<double>(record.samples()) * linear_parts * problem.settings.passes;
}

int filter_threads(const EstimationSettings& settings) {
  const int given = settings.threads;
  return given > 0 ? given : processors();
}

}  // namespace kalfem
