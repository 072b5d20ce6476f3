// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/sensor_unknowns.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;
using Kind = LikelihoodUnknownKind;

const std::string process_noise = "process_noise";
const std::string of_sensors = "sensors.";

/// "gain" of "sensors.a3.gain".
std::string quantity_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

std::string sensor_of(const std::string& name) {
  return name.substr(of_sensors.size(), name.rfind('.') - of_sensors.size());
}

Kind kind_of(const std::string& quantity) {
  if (quantity == "gain") return Kind::sensor_gain;
  if (quantity == "delay") return Kind::sensor_delay;
  return quantity == "noise" ? Kind::sensor_noise : Kind::process_noise;
}

void check_sensor(const CaseStudy& study, const std::string& name, const d::Unknown& given) {
  std::vector<std::string> names;
  for (const auto& sensor : study.sensors) names.push_back(sensor.name);
  if (std::ranges::find(names, sensor_of(name)) != names.end()) return;
  throw InvalidInput({given.initial.location,
                      "estimate.unknown." + name + ": there is no sensor '" + sensor_of(name) + "'" +
                          did_you_mean(sensor_of(name), names),
                      "", "name a sensor of the case"});
}

/// What only an unknown of the structure can have.
void refuse_other_keys(const std::string& name, const d::Unknown& given) {
  const bool drifts = quantity_of(name) == "offset";
  std::string key;
  if (given.transform) key = "transform";
  if (given.bounds) key = "bounds";
  if (given.random_walk && !drifts) key = "random_walk";
  if (!given.applies_to.empty()) key = "applies_to";
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

/// Prior deviation; without one, half of a gain, and a factor of ten of noise.
double deviation_of(const std::string& name, const d::Unknown& given, const std::string& unit, double initial) {
  const std::string quantity = quantity_of(name);
  const bool of_noise = quantity == "noise" || quantity == process_noise;
  if (!given.std && (quantity == "delay" || quantity == "offset"))
    throw InvalidInput(given.initial.issue("it has no `std`", "nothing says how far it may be from its initial value",
                                           "give std in " + unit));
  const double deviation =
      given.std ? spread(*given.std, unit, initial) : std::abs(initial) * (of_noise ? std::log(10.0) : 0.5);
  if (deviation > 0.0 && std::isfinite(deviation)) return deviation;
  throw InvalidInput(given.initial.issue("its standard deviation is " + shortest(deviation), "it must be > 0",
                                         "to hold it fixed, remove it from estimate.unknown"));
}

void add_offset(const std::string& name, const d::Unknown& given, const std::string& unit, EstimationProblem& problem) {
  SensorOffset offset{.name = name, .sensor = sensor_of(name)};
  offset.initial = checked_number(given.initial, unit);
  offset.deviation = deviation_of(name, given, unit, offset.initial);
  if (given.random_walk) offset.random_walk = spread(*given.random_walk, unit, offset.initial);
  if (given.truth) offset.truth = checked_number(*given.truth, unit);
  problem.offsets.push_back(std::move(offset));
}

void add_by_likelihood(const std::string& name, const d::Unknown& given, const std::string& unit,
                       EstimationProblem& problem) {
  const std::string quantity = quantity_of(name);
  LikelihoodUnknown unknown{.name = name, .kind = kind_of(quantity), .unit = unit};
  if (name != process_noise) unknown.sensor = sensor_of(name);
  unknown.initial = checked_number(given.initial, unit);
  if (quantity == "gain" && unknown.initial == 0.0)
    throw InvalidInput(given.initial.issue("a gain of 0 is given", "such a sensor shows nothing", "start at 1"));
  if ((quantity == "noise" || quantity == process_noise) && !(unknown.initial > 0.0))
    throw InvalidInput(given.initial.issue(shortest(unknown.initial) + " is given",
                                           "noise is searched by its logarithm", "give a positive initial value"));
  unknown.deviation = deviation_of(name, given, unit, unknown.initial);
  if (given.truth) unknown.truth = checked_number(*given.truth, unit);
  problem.settings.likelihood_unknowns.push_back(std::move(unknown));
}

}  // namespace

bool is_measurement_unknown(const std::string& name) {
  if (name == process_noise) return true;
  if (!name.starts_with(of_sensors) || name.rfind('.') < of_sensors.size()) return false;
  const std::string quantity = quantity_of(name);
  return quantity == "gain" || quantity == "delay" || quantity == "offset" || quantity == "noise";
}

std::string measurement_unit(const std::vector<Sensor>& sensors, const std::string& name) {
  const std::string quantity = quantity_of(name);
  if (quantity == "gain") return "-";
  if (quantity == "delay") return "s";
  if (name == process_noise) return "m/s^2/sqrt(Hz)";
  return std::ranges::find(sensors, sensor_of(name), &Sensor::name)->unit;
}

void add_measurement_unknown(const CaseStudy& study, const std::string& name, const d::Unknown& given,
                             EstimationProblem& problem) {
  if (name != process_noise) check_sensor(study, name, given);
  refuse_other_keys(name, given);
  const std::string unit = measurement_unit(study.sensors, name);
  if (quantity_of(name) == "offset") return add_offset(name, given, unit, problem);
  if (study.given.update)
    throw InvalidInput({given.initial.location,
                        "estimate.unknown." + name + " is found by maximum likelihood, but the case has `update`",
                        "each step of the updating would search it again",
                        "find it in a run without `update`, then state it: gain and delay in the sensor's `chain`"});
  add_by_likelihood(name, given, unit, problem);
}

}  // namespace kalfem
