// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/measurement_unknowns.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

using Kind = LikelihoodUnknownKind;

const std::string process_noise = "process_noise";
const std::string of_sensors = "sensors.";

/// "gain" of "sensors.a3.gain".
std::string quantity_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

bool is_noise(const std::string& quantity) { return quantity == "noise" || quantity == process_noise; }

Kind kind_of(const std::string& quantity) {
  if (quantity == "gain") return Kind::sensor_gain;
  if (quantity == "delay") return Kind::sensor_delay;
  return quantity == "noise" ? Kind::sensor_noise : Kind::process_noise;
}

double deviation_of(const std::string& quantity, const MeasurementPrior& prior, const std::string& unit) {
  if (!prior.deviation && (quantity == "delay" || quantity == "offset"))
    throw InvalidInput("it has no `std`", "nothing says how far it may be from its initial value",
                       "give std in " + unit);
  const double deviation =
      prior.deviation.value_or(std::abs(prior.initial) * (is_noise(quantity) ? std::log(10.0) : 0.5));
  if (deviation > 0.0 && std::isfinite(deviation)) return deviation;
  throw InvalidInput("its standard deviation is " + shortest(deviation), "it must be > 0",
                     "to hold it fixed, remove it from the unknowns");
}

void check_initial(const std::string& quantity, double initial) {
  if (!std::isfinite(initial))
    throw InvalidInput("it starts at " + shortest(initial), "a number is needed", "give a finite initial value");
  if (quantity == "gain" && initial == 0.0)
    throw InvalidInput("a gain of 0 is given", "such a sensor shows nothing", "start at 1");
  if (is_noise(quantity) && !(initial > 0.0))
    throw InvalidInput(shortest(initial) + " is given", "noise is searched by its logarithm",
                       "give a positive initial value");
}

}  // namespace

bool is_measurement_unknown(const std::string& name) {
  if (name == process_noise) return true;
  if (!name.starts_with(of_sensors) || name.rfind('.') < of_sensors.size()) return false;
  const std::string quantity = quantity_of(name);
  return quantity == "gain" || quantity == "delay" || quantity == "offset" || quantity == "noise";
}

std::string measured_sensor(const std::string& name) {
  return name == process_noise ? "" : name.substr(of_sensors.size(), name.rfind('.') - of_sensors.size());
}

bool is_found_by_likelihood(const std::string& name) { return quantity_of(name) != "offset"; }

std::string measurement_unit(const std::vector<Sensor>& sensors, const std::string& name) {
  const std::string quantity = quantity_of(name);
  if (quantity == "gain") return "-";
  if (quantity == "delay") return "s";
  if (name == process_noise) return "m/s^2/sqrt(Hz)";
  return std::ranges::find(sensors, measured_sensor(name), &Sensor::name)->unit;
}

void add_measurement_unknown(const std::string& name, const MeasurementPrior& prior, EstimationProblem& problem) {
  const std::string quantity = quantity_of(name), unit = measurement_unit(problem.sensors, name);
  check_initial(quantity, prior.initial);
  const double deviation = deviation_of(quantity, prior, unit);
  if (is_found_by_likelihood(name))
    problem.settings.likelihood_unknowns.push_back({.name = name,
                                                    .kind = kind_of(quantity),
                                                    .sensor = measured_sensor(name),
                                                    .unit = unit,
                                                    .initial = prior.initial,
                                                    .deviation = deviation,
                                                    .truth = prior.truth});
  else
    problem.offsets.push_back({.name = name,
                               .sensor = measured_sensor(name),
                               .deviation = deviation,
                               .initial = prior.initial,
                               .random_walk = prior.random_walk,
                               .truth = prior.truth});
}

}  // namespace kalfem
