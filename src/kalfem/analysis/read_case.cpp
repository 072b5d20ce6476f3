// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/analysis/analysis.hpp"
#include "kalfem/analysis/case_origin.hpp"
#include "kalfem/analysis/expressible.hpp"
#include "kalfem/analysis/read_updating.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"
#include "kalfem/steps/simulation/compute.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
namespace {

Structure structure_of(const Study& study) {
  StructureDescription described;
  described.parts = study.structure->parts;
  described.parts.finite_elements.clear();
  described.signals = study.structure->signals;
  described.read = {study.structure->finite_elements,
                    std::make_shared<const CaseOrigin>(study.description, study.structure)};
  return Structure(described);
}

/// The measured record, or the simulated one.
std::optional<Record> record_of(const Study& study, const Progress& progress) {
  if (study.record) return study.record->record;
  if (!study.simulation || study.sensors.empty()) return std::nullopt;
  std::string failure;
  Record record = run_simulation(study, progress, failure).measurements;
  if (!failure.empty()) throw InvalidInput(failure, "the case has no record", "");
  return record;
}

std::vector<SensorDescription> sensors_of(const Study& study, const Record& record) {
  std::vector<SensorDescription> sensors;
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto& sensor = study.sensors[i];
    sensors.push_back({.name = sensor.name,
                       .output = sensor.output,
                       .noise = record.channels[i].noise,
                       .chain = {study.description->sensors[i].second.chain}});
  }
  return sensors;
}

/// The numbers that share an unknown, if it has a name of its own.
std::vector<std::string> applies_to(const LikelihoodUnknown& unknown) {
  std::vector<std::string> numbers;
  for (const auto& sensor : unknown.sensors) numbers.push_back("sensors." + sensor + "." + quantity_of(unknown.name));
  return numbers == std::vector{unknown.name} ? std::vector<std::string>{} : numbers;
}

/// Unknowns of the structure, then those of the measurement.
std::vector<UnknownDescription> unknowns_of(const EstimationProblem& problem) {
  std::vector<UnknownDescription> unknowns;
  for (const auto& unknown : problem.settings.unknowns) {
    Prior prior{.initial = unknown.initial,
                .std = unknown.deviation,
                .random_walk = unknown.random_walk,
                .transform = unknown.transform};
    if (unknown.targets.size() > 1 || unknown.targets.front().name != unknown.name)
      for (const auto& target : unknown.targets) prior.applies_to.push_back(target.name);
    unknowns.push_back({unknown.name, prior});
  }
  for (const auto& offset : problem.offsets)
    unknowns.push_back(
        {offset.name, {.initial = offset.initial, .std = offset.deviation, .random_walk = offset.random_walk}});
  for (const auto& unknown : problem.settings.likelihood_unknowns)
    unknowns.push_back(
        {unknown.name, {.initial = unknown.initial, .std = unknown.deviation, .applies_to = applies_to(unknown)}});
  return unknowns;
}

template <class T>
std::vector<std::pair<std::string, T>> without_places(const Named<Located<T>>& given) {
  std::vector<std::pair<std::string, T>> all;
  for (const auto& [name, value] : given) all.emplace_back(name, value.value);
  return all;
}

/// As the command computes standard deviations of the motion, a hundred times a second.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

EstimateOptions options_of(const Study& study, const Record& record) {
  const auto& settings = study.problem->settings;
  return {.sensors = sensors_of(study, record),
          .unknowns = unknowns_of(*study.problem),
          .initial_state = without_places(settings.initial_state),
          .initial_connector_states = without_places(settings.initial_connector_states),
          .process_noise = settings.process_noise.acceleration,
          .filter = settings.filter,
          .substeps = settings.substeps,
          .step_order = settings.step_order,
          .threads = settings.threads,
          .initial_state_from_record = settings.initial_state_from_record,
          .estimate_initial_state = settings.estimate_initial_state,
          .passes = settings.passes,
          .settle = settings.settle,
          .deviation_stride = samples_between_deviations(study.sample_rate()),
          .diagnose = settings.diagnose,
          .second_thoughts = study.description->estimate->second_thoughts,
          .known_to = settings.known_to,
          .free = settings.free,
          .adaptive_noise = {settings.adaptive_noise.sensors, settings.adaptive_noise.process,
                             settings.adaptive_noise.memory}};
}

}  // namespace

Analysis read_case(const std::filesystem::path& file, const ReadCaseOptions& options) {
  std::vector<CaseChange> changes;
  for (const auto& [key, value] : options.set) changes.push_back({key, value});
  const Study study = load_study(file.string(), changes, options.progress);
  require_expressible(study);
  Analysis analysis{
      .title = study.title, .structure = structure_of(study), .left_out = sections_left_out(*study.description)};
  if (options.record) analysis.record = record_of(study, options.progress);
  if (study.updating) analysis.update = update_options_of(study);
  if (study.problem && analysis.record) analysis.estimate = options_of(study, *analysis.record);
  return analysis;
}

}  // namespace kalfem
