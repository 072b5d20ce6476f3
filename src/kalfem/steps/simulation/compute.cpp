// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/simulation/compute.hpp"

#include <cmath>
#include <string>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/steps/field_series.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// A model with more degrees of freedom is simulated in a thread of its own. Smaller ones are stepped so fast that what
/// their solutions keep of every step is what counts: one at a time.
constexpr Index large_model = 2000;

std::vector<MeasurementChain> chains_of(const std::vector<Sensor>& sensors) {
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : sensors) chains.push_back(sensor.chain);
  return chains;
}

/// States why there is no reference, and the remedy. A finer step does not help if the trajectories diverge at every
/// step size.
std::string not_converged(const ConvergedSolution& reference, int max_substeps) {
  if (!reference.stagnates())
    return "the simulation did not converge: refining the step to 1/" + std::to_string(reference.substeps) +
           " of a sample still changes a sensor's record by " + shortest(reference.last_change) +
           " of its rms; raise simulate.max_substeps or simulate.tolerance";
  std::string changes;
  for (std::size_t i = reference.changes.size() - 3; i < reference.changes.size(); ++i)
    changes += (changes.empty()                     ? ""
                : i + 1 == reference.changes.size() ? " and "
                                                    : ", ") +
               shortest(std::round(1e3 * reference.changes[i]) / 1e3);
  return "the motion is chaotic or very sensitive: refining the step does not reduce the difference between two "
         "records (" +
         changes +
         " of a sensor's rms in the last three refinements), so more substeps cannot help; use a fixed step with "
         "simulate.substeps: " +
         std::to_string(max_substeps) + ", which gives one of the possible motions, or simulate a shorter time";
}

}  // namespace

SimulationOutcome run_simulation(const Study& study, const Progress& progress, std::string& failure) {
  const SimulationPlan& plan = *study.simulation;
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : study.sensors) outputs.push_back(sensor.output);
  const Stopwatch watch;
  ConvergenceOptions convergence = plan.convergence;
  convergence.threads = study.model->system().size() > large_model ? processors() : 1;
  SimulationOptions options = plan.integration;
  options.progress = progress;
  options.keep_motion = false;
  const auto reported = reported_quantities(*study.model);
  options.every_sample = make_outputs(*study.model, reported);
  FieldCollector collector(study);
  collector.attach(options);
  SimulationOutcome outcome;
  outcome.reference =
      simulate_converged(study.model->system(), study.structure->signals, initial_state(plan.initial, *study.model),
                         make_outputs(*study.model, outputs), chains_of(study.sensors), options, convergence);
  if (outcome.reference.simulation.failure)
    failure = "the simulation stopped at " + shortest(outcome.reference.simulation.failure->time) +
              " s: " + outcome.reference.simulation.failure->reason;
  else if (!outcome.reference.converged && !study.sensors.empty() && !plan.has_fixed_step())
    failure = not_converged(outcome.reference, plan.convergence.max_substeps);
  else
    add_noise(study, plan.seed, outcome);
  const auto& values = outcome.reference.simulation.every_sample;
  for (std::size_t i = 0; i < reported.size(); ++i)
    outcome.points.push_back(
        {reported[i].name, reported[i].quantity, values.row(static_cast<Index>(i)).transpose(), {}, {}, {}, {}});
  outcome.reference.simulation.every_sample.resize(0, 0);
  if (auto series = collector.take()) outcome.fields.push_back(std::move(*series));
  outcome.seconds = watch.seconds();
  return outcome;
}

void add_noise(const Study& study, std::uint64_t seed, SimulationOutcome& outcome) {
  const auto& clean = outcome.reference.sensors;
  outcome.measurements = {.sample_rate = study.simulation->sample_rate, .values = clean};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& sensor = study.sensors[i];
    const double noise = sensor.deviation(rms(clean.row(row).transpose()));
    outcome.measurements.channels.push_back({sensor.name, sensor.unit, noise});
    RandomStream random(seed, sensor.name);
    for (double& value : outcome.measurements.values.row(row)) value += noise * random.normal();
  }
}

}  // namespace kalfem
