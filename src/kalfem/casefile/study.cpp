#include "kalfem/casefile/study.hpp"

#include <cmath>

#include "kalfem/casefile/bounds.hpp"
#include "kalfem/casefile/case_reader.hpp"
#include "kalfem/casefile/modifications.hpp"
#include "kalfem/casefile/observer_setup.hpp"
#include "kalfem/casefile/parameterised_structure.hpp"
#include "kalfem/casefile/study_elements.hpp"
#include "kalfem/casefile/updating_setup.hpp"

namespace kalfem {
namespace {

namespace d = description;

StudySensor make_sensor(const std::string& name, const d::Sensor& given) {
  StudySensor sensor;
  sensor.name = name;
  std::visit(
      [&](const auto& observed) {
        sensor.output = {
            name, observed.quantity, {observed.points.value.begin(), observed.points.value.end()}, given.relative};
      },
      given.observed);
  sensor.unit = unit_of(sensor.output.quantity);
  sensor.relative_noise = !given.noise.value.bare && given.noise.value.dimension == Dimension{};
  sensor.noise =
      sensor.relative_noise ? given.noise.value.value : checked_number(given.noise, sensor.unit, Bounds::nonnegative());
  if (!(sensor.noise >= 0.0))
    throw InvalidInput(given.noise.issue("the noise is negative", "it is a standard deviation"));
  sensor.chain = MeasurementChain({given.chain});
  return sensor;
}

void add_sensors(Study& study, IssueList& issues) {
  std::vector<OutputDescription> outputs;
  for (const auto& [name, given] : study.given.sensors) {
    try {
      study.sensors.push_back(make_sensor(name, given));
      make_outputs(*study.model, {study.sensors.back().output});
    } catch (const InvalidInput& error) {
      const auto location = std::visit([](const auto& observed) { return observed.points.location; }, given.observed);
      issues.add(error, location);
    }
  }
}

void check_stages(const d::Case& given, const SourceLocation& file, IssueList& issues) {
  if (given.simulate && given.record)
    issues.add(file, "the case has both `simulate` and `record`", "there can be one record only",
               "take one of them out");
  if (given.estimate && !given.simulate && !given.record)
    issues.add(file, "the case estimates but has no record", "", "add `simulate` or `record`");
  if (given.estimate && given.sensors.empty())
    issues.add(file, "the case estimates but has no sensors", "", "add at least one under `sensors`");
  if (given.predict && !given.estimate)
    issues.add(file, "the case predicts but does not estimate",
               "the prediction is driven by the estimated boundary motion", "add `estimate`");
  if (given.estimate && given.estimate->passes > 1 && !given.estimate->estimate_initial_state)
    issues.add(file, "estimate.passes is above 1 without estimate_initial_state",
               "each pass starts from the initial state "
               "that the last one estimated",
               "set estimate.estimate_initial_state: true");
  for (const auto& [name, sensor] : given.sensors)
    if (given.estimate && sensor.noise.value.value == 0.0)
      issues.add(sensor.noise.location, sensor.noise.path + ": the noise is 0",
                 "the filter cannot weigh a sensor without "
                 "noise",
                 "give a small one");
}

void check_prediction(const Study& study, IssueList& issues) {
  if (!study.given.predict) return;
  const auto& name = study.given.predict->substructure;
  std::vector<std::string> known;
  for (const auto& [part, given] : study.given.substructures) known.push_back(part);
  if (std::ranges::find(known, name.value) == known.end())
    issues.add(name.location,
               name.path + ": there is no substructure '" + name.value + "'" + did_you_mean(name.value, known));
}

/// Pictures are of finite elements.
void check_pictures(const d::Case& given, IssueList& issues) {
  if (!given.report.fields) return;
  const auto& name = given.report.fields->substructure;
  std::vector<std::string> known;
  for (const auto& [part, substructure] : given.substructures)
    if (substructure.finite_elements) known.push_back(part);
  if (std::ranges::find(known, name.value) == known.end())
    issues.add(
        name.location,
        name.path + ": there is no finite-element substructure '" + name.value + "'" + did_you_mean(name.value, known),
        "the motion of a mesh is drawn", "name one that has finite_elements");
}

/// The parts from which the observer is made: an updating begins at its own first guesses.
Parts starting_parts(const Study& study) {
  if (!study.updating) return study.parts;
  return parameterised_structure(study)->at(initial_values(study.updating->parameters)).parts;
}

/// What is allowed but probably not meant.
void warn(Study& study) {
  if (study.given.estimate && study.given.simulate && study.given.estimate->settle >= study.given.simulate->duration)
    study.warnings.push_back(
        "estimate.settle is no shorter than the record: errors and NIS are of its last sample alone");
  if (!study.observer) return;
  for (const auto& unknown : study.observer->options.unknowns) {
    const auto& given = std::ranges::find(study.given.estimate->unknown, unknown.name,
                                          &std::pair<std::string, d::Unknown>::first)->second;
    if (unknown.transform.kind == TransformKind::none && given.std && !given.std->value.bare &&
        unknown.initial != 0.0 && unknown.deviation > 0.6 * std::abs(unknown.initial))
      study.warnings.push_back("unknown '" + unknown.name +
                               "' has a wide prior and no transform: sigma points may become negative; "
                               "set transform: log");
  }
}

}  // namespace

double Study::sample_rate() const {
  return record ? record->series.sample_rate : given.simulate ? given.simulate->sample_rate : 0.0;
}

Study load_study(const std::string& file) { return make_study(read_case(file, d::case_form()), file); }

Study make_study(d::Case given, const std::string& file) {
  Study study;
  study.file = file;
  study.given = std::move(given);
  IssueList issues;
  const SourceLocation place{file, 0};
  check_stages(study.given, place, issues);
  add_finite_elements(study, issues);
  study.parts = make_parts(study.given, reduced_parts(study), place, issues);
  const double duration = study.given.simulate ? study.given.simulate->duration : 10.0;
  study.signals = make_signals(study.given, study.parts.inputs, duration, issues);
  check_prediction(study, issues);
  check_pictures(study.given, issues);
  raise_in_line_order(issues);
  try {
    study.model = std::make_shared<const CoupledModel>(couple(reference_parts(study)));
    add_sensors(study, issues);
    if (study.given.record) study.record = read_measured_record(study.given);
  } catch (const InvalidInput& error) {
    issues.add(error, place);
  }
  raise_in_line_order(issues);
  try {
    if (study.given.update) study.updating = make_updating_setup(study, issues);
    check_modifications(study, issues);
  } catch (const InvalidInput& error) {
    issues.add(error, place);
  }
  raise_in_line_order(issues);
  try {
    if (study.given.estimate) study.observer = make_observer_setup(study, starting_parts(study), {}, issues);
  } catch (const InvalidInput& error) {
    issues.add(error, place);
  }
  raise_in_line_order(issues);
  warn(study);
  warn_of_reductions(study);
  return study;
}

}  // namespace kalfem
