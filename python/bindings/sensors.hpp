// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// What a sensor of Python holds: everything but its name, which is its key.
struct Observation {
  OutputDescription output;
  double noise = 0.0;
  MeasurementChainOptions chain = {};
};

/// {"a3": acceleration("body.2", noise=0.3)} in the order of the dictionary.
std::vector<SensorDescription> sensors_of(const py::dict& sensors);
/// The same as quantities to estimate.
std::vector<OutputRequest> outputs_of(const py::dict& outputs);

/// A number in SI, or a text with a unit: "3 mm". Throws InvalidInput with the argument's name, and where the unit has
/// another dimension than the given one. Of an empty one nothing is known.
double number_of(const py::handle& given, const std::string& unit, const std::string& argument);

}  // namespace kalfem::python
