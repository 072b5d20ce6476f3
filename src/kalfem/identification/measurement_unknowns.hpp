// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"

namespace kalfem {

/// Whether an unknown of this name is one of the measurement or of the noise: sensors.NAME.gain, .delay, .drift,
/// .offset or .noise, or process_noise.
bool is_measurement_unknown(const std::string& name);

/// "gain" of "sensors.a3.gain".
std::string quantity_of(const std::string& name);

/// Its sensor; empty for process_noise.
std::string measured_sensor(const std::string& name);

/// The sensors of an unknown: its own, or those of the numbers that share it. Throws InvalidInput, which does not name
/// it, where these are other quantities or cannot be shared.
std::vector<std::string> measured_sensors(const std::string& name, const std::vector<std::string>& applies_to);

/// Whether it is found by maximum likelihood as one number for the whole record: all but an offset are, which is a
/// state of the filter.
bool is_found_by_likelihood(const std::string& name);

/// Its SI unit. The sensor is one of these.
std::string measurement_unit(const std::vector<Sensor>& sensors, const std::string& name);

/// What is known of it beforehand, in its unit.
struct MeasurementPrior {
  double initial = 0.0;
  std::optional<double> deviation = {};  ///< if empty, half of a gain, and a factor of ten of noise
  double random_walk = 0.0;              ///< of an offset [unit/sqrt(s)]
  std::optional<double> truth = {};
  std::vector<std::string> applies_to = {};  ///< "sensors.a3.drift" and others that share a gain, delay or drift
};

/// Adds it to the problem. Throws InvalidInput, which does not name it, for numbers that do not fit.
void add_measurement_unknown(const std::string& name, const MeasurementPrior& prior, EstimationProblem& problem);

}  // namespace kalfem
