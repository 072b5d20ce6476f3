// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/sensor_unknowns.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/study/spread.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// The numbers that share the unknown, if there are several.
std::vector<std::string> shared_by(const d::Unknown& given) {
  std::vector<std::string> names;
  for (const auto& each : given.applies_to) names.push_back(each.value);
  return names;
}

void check_sensors(const CaseStudy& study, const std::string& name, const d::Unknown& given) {
  std::vector<std::string> names;
  for (const auto& each : study.sensors) names.push_back(each.name);
  for (const auto& sensor : measured_sensors(name, shared_by(given)))
    if (std::ranges::find(names, sensor) == names.end())
      throw InvalidInput(
          {given.initial.location,
           "estimate.unknown." + name + ": there is no sensor '" + sensor + "'" + did_you_mean(sensor, names), "",
           "name a sensor of the case"});
}

/// What only an unknown of the structure can have.
void refuse_other_keys(const std::string& name, const d::Unknown& given) {
  const bool drifts = !is_found_by_likelihood(name);
  std::string key;
  if (given.transform) key = "transform";
  if (given.bounds) key = "bounds";
  if (given.random_walk && !drifts) key = "random_walk";
  if (!key.empty())
    throw InvalidInput({given.initial.location, "estimate.unknown." + name + "." + key + " has no meaning here",
                        drifts ? "an offset is a number with a normal prior that may drift"
                               : "it is found by maximum likelihood as one number for the whole record",
                        "remove the key"});
}

/// A standard deviation or a walk, in per cent of the initial value too.
double spread(const d::Value& given, const std::string& unit, double initial) {
  const bool percentage = !given.value.bare && given.value.dimension == Dimension{} && unit != "-";
  return percentage ? given.value.value * std::abs(initial) : checked_number(given, unit, Bounds::nonnegative());
}

MeasurementPrior prior_of(const d::Unknown& given, const std::string& unit) {
  MeasurementPrior prior{.initial = checked_number(given.initial, unit), .applies_to = shared_by(given)};
  if (given.std) prior.deviation = spread(*given.std, unit, prior.initial);
  if (given.random_walk) prior.random_walk = spread(walk_in(*given.random_walk, unit), unit, prior.initial);
  if (given.truth) prior.truth = checked_number(*given.truth, unit);
  return prior;
}

}  // namespace

void add_measurement_unknown(const CaseStudy& study, const std::string& name, const d::Unknown& given,
                             EstimationProblem& problem) {
  refuse_other_keys(name, given);
  if (is_found_by_likelihood(name) && study.given.update)
    throw InvalidInput({given.initial.location,
                        "estimate.unknown." + name + " is found by maximum likelihood, but the case has `update`",
                        "each step of the updating would search it again",
                        "find it in a run without `update`, then state it with the sensor: `gain`, `delay`, `drift`"});
  try {
    check_sensors(study, name, given);
    const MeasurementPrior prior = prior_of(given, measurement_unit(study.sensors, name));
    add_measurement_unknown(name, prior, problem);
  } catch (const InvalidInput& error) {
    const auto& [location, what, why, fix] = error.issues().front();
    if (!location.file.empty()) throw;
    throw InvalidInput(given.initial.issue(what, why, fix));
  }
}

}  // namespace kalfem
