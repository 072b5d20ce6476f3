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

constexpr double largest_drift = 0.1;  ///< far beyond any clock: a number that was meant in ppm

bool is_noise(const std::string& quantity) { return quantity == "noise" || quantity == process_noise; }

Kind kind_of(const std::string& quantity) {
  if (quantity == "gain") return Kind::sensor_gain;
  if (quantity == "delay") return Kind::sensor_delay;
  if (quantity == "drift") return Kind::sensor_drift;
  return quantity == "noise" ? Kind::sensor_noise : Kind::process_noise;
}

void check_drift(const std::string& quantity, double value) {
  if (quantity == "drift" && std::abs(value) > largest_drift)
    throw InvalidInput("a drift of " + shortest(value) + " s/s is given", "no clock runs that wrong",
                       "give it in ppm, such as 50 ppm or 5e-5");
}

double deviation_of(const std::string& quantity, const MeasurementPrior& prior, const std::string& unit) {
  if (!prior.deviation && (quantity == "delay" || quantity == "drift" || quantity == "offset"))
    throw InvalidInput("it has no `std`", "nothing says how far it may be from its initial value",
                       quantity == "drift" ? "give std in ppm" : "give std in " + unit);
  const double deviation =
      prior.deviation.value_or(std::abs(prior.initial) * (is_noise(quantity) ? std::log(10.0) : 0.5));
  check_drift(quantity, deviation);
  if (deviation > 0.0 && std::isfinite(deviation)) return deviation;
  throw InvalidInput("its standard deviation is " + shortest(deviation), "it must be > 0",
                     "to hold it fixed, remove it from the unknowns");
}

void check_initial(const std::string& quantity, double initial) {
  if (!std::isfinite(initial))
    throw InvalidInput("it starts at " + shortest(initial), "a number is needed", "give a finite initial value");
  check_drift(quantity, initial);
  if (quantity == "gain" && initial == 0.0)
    throw InvalidInput("a gain of 0 is given", "such a sensor shows nothing", "start at 1");
  if (is_noise(quantity) && !(initial > 0.0))
    throw InvalidInput(shortest(initial) + " is given", "noise is searched by its logarithm",
                       "give a positive initial value");
}

bool can_be_shared(const std::string& quantity) {
  return quantity == "gain" || quantity == "delay" || quantity == "drift";
}

}  // namespace

std::string quantity_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

bool is_measurement_unknown(const std::string& name) {
  if (name == process_noise) return true;
  if (!name.starts_with(of_sensors) || name.rfind('.') < of_sensors.size()) return false;
  const std::string quantity = quantity_of(name);
  return can_be_shared(quantity) || quantity == "offset" || quantity == "noise";
}

std::string measured_sensor(const std::string& name) {
  return name == process_noise ? "" : name.substr(of_sensors.size(), name.rfind('.') - of_sensors.size());
}

std::vector<std::string> measured_sensors(const std::string& name, const std::vector<std::string>& applies_to) {
  if (applies_to.empty())
    return name == process_noise ? std::vector<std::string>{} : std::vector{measured_sensor(name)};
  const std::string quantity = quantity_of(name);
  if (!can_be_shared(quantity))
    throw InvalidInput("applies_to: a " + quantity + " is given for several sensors",
                       "gains, delays and drifts can be shared", "give each sensor an unknown of its own");
  std::vector<std::string> sensors;
  for (const auto& each : applies_to) {
    if (!is_measurement_unknown(each) || quantity_of(each) != quantity)
      throw InvalidInput("applies_to: '" + each + "' is no " + quantity + " of a sensor", "one number stands for all",
                         "write sensors.NAME." + quantity);
    sensors.push_back(measured_sensor(each));
  }
  return sensors;
}

bool is_found_by_likelihood(const std::string& name) { return quantity_of(name) != "offset"; }

std::string measurement_unit(const std::vector<Sensor>& sensors, const std::string& name) {
  const std::string quantity = quantity_of(name);
  if (quantity == "gain" || quantity == "drift") return "-";
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
                                                    .sensors = measured_sensors(name, prior.applies_to),
                                                    .unit = unit,
                                                    .initial = prior.initial,
                                                    .deviation = deviation,
                                                    .truth = prior.truth,
                                                    .since = problem.settings.clocks_since});
  else
    problem.offsets.push_back({.name = name,
                               .sensor = measured_sensor(name),
                               .deviation = deviation,
                               .initial = prior.initial,
                               .random_walk = prior.random_walk,
                               .truth = prior.truth});
}

}  // namespace kalfem
