// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/simulation/checkpoint.hpp"
#include "kalfem/steps/simulation/compute.hpp"
#include "kalfem/steps/updating/outcome.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

/// The simulation that is given, or that of an earlier run that was killed after it.
std::optional<SimulationOutcome> made_already(const RunOptions& options, const SimulationCheckpoint& checkpoint) {
  const Stopwatch watch;
  auto outcome = options.simulation ? std::optional(options.simulation()) : checkpoint.read();
  if (outcome) outcome->seconds = watch.seconds();
  return outcome;
}

/// Takes the simulation that is made already; otherwise makes it and keeps it.
void simulate(RunContext& context) {
  auto& results = context.results;
  const Progress progress = context.job.begin("simulate");
  const SimulationCheckpoint checkpoint(context.options.simulation ? "" : context.options.folder, context.study);
  if (auto outcome = made_already(context.options, checkpoint)) {
    results.put(std::move(*outcome));
    return;
  }
  const auto& outcome = results.put(run_simulation(context.study, progress, results.failure));
  if (results.complete()) checkpoint.write(outcome);
}

/// Nothing where the step was not refined.
Json last_change(const Study& study, const ConvergedSolution& reference) {
  return study.simulation->has_fixed_step() ? Json() : number(reference.last_change);
}

Json simulation_summary(const Study& study, const ConvergedSolution& reference) {
  return {{"steps_per_sample", reference.substeps},
          {"extrapolations", reference.extrapolations},
          {"fixed_step", study.simulation->has_fixed_step()},
          {"last_change", last_change(study, reference)},
          {"solve_error", reference.simulation.solve_error}};
}

std::string told(const Study& study, const StudyResults& results) {
  const auto& outcome = results.get<SimulationOutcome>();
  const auto& reference = outcome.reference;
  const double solve_error = reference.simulation.solve_error;
  const bool of_superelements =
      std::ranges::any_of(study.structure->finite_elements, [](const auto& each) { return each.reference != nullptr; });
  return fmt::format(
      "Simulation: {} degrees of freedom{}, {} s at {} Hz, {} steps per sample{} ({}{}), {:.1f} s\n\n",
      study.model->system().size(), of_superelements ? " (superelements)" : "", four_digits(study.simulation->duration),
      four_digits(study.sample_rate()), reference.substeps, reference.extrapolations > 0 ? " and extrapolated" : "",
      study.simulation->has_fixed_step() ? "a fixed step" : "last change " + per_cent(reference.last_change),
      solve_error > 0.0 ? fmt::format(", steps solved in single precision to {:.0e}", solve_error) : "",
      outcome.seconds);
}

Section simulation_section(const SimulationOutcome& outcome) {
  Section section{"Record", "Simulated sensors, with noise.", {}};
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& channel = outcome.measurements.channels[i];
    section.items.emplace_back(Chart{.id = "record-" + channel.name,
                                     .title = channel.name,
                                     .x_label = "time [s]",
                                     .y_label = "[" + channel.unit + "]",
                                     .x = times(outcome.measurements),
                                     .series = {{.label = "recorded",
                                                 .y = series_values(outcome.measurements.values.row(row).transpose()),
                                                 .role = Role::measured},
                                                {.label = "without noise",
                                                 .y = series_values(outcome.reference.sensors.row(row).transpose()),
                                                 .role = Role::truth}},
                                     .half_width = true});
  }
  return section;
}

/// The record, where no filter shows it.
std::vector<PlacedSection> sections(const Study&, const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  const auto& outcome = results.get<SimulationOutcome>();
  if ((estimation && estimation->has_samples()) || outcome.measurements.samples() == 0) return {};
  return {{PagePlace::consistency, simulation_section(outcome)}};
}

void write_truth(SeriesWriter& file, const Study& study, const SimulationOutcome& outcome) {
  file.write_points("/truth", outcome.points);
  const auto& inputs = outcome.reference.simulation.trajectory.inputs;
  for (Eigen::Index i = 0; i < study.model->system().input_count(); ++i) {
    const auto& input = study.model->system().inputs[static_cast<std::size_t>(i)];
    file.write("/inputs/" + input.name, inputs.row(i).transpose(), input.unit);
  }
}

}  // namespace

RunStep simulation_step() {
  return {.name = "simulate",
          .meaning = "simulate the structure and make its record",
          .asked_for = [](const Study& study) { return study.simulation.has_value(); },
          .with = {"modes"},
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"simulate", 4.0}};
              },
          .run = &simulate,
          .checkpoint = {.file = simulation_name, .outlives_step = true},
          .ran = &has_outcome<SimulationOutcome>,
          .seconds = &seconds_of<SimulationOutcome>,
          .summarise =
              [](const Study& study, const StudyResults& results, Json& summary) {
                summary["simulation"] = simulation_summary(study, results.get<SimulationOutcome>().reference);
              },
          .tell = &told,
          .answer =
              [](const Study&, const StudyResults& results) {
                return std::string(results.has<UpdatingOutcome>() ? "" : "The simulation is complete.");
              },
          .sections = &sections,
          .visit = [](const Study& study, const StudyResults& results,
                      SeriesWriter& file) { write_truth(file, study, results.get<SimulationOutcome>()); },
          .write =
              [](const std::filesystem::path& folder, const Study& study, const StudyResults& results) {
                write_field_series(folder, study, results.get<SimulationOutcome>().fields);
              }};
}

}  // namespace kalfem
