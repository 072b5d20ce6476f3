// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// What a sensor of Python holds: everything but its name, which is its key.
struct Observation {
  OutputDescription output;
  double noise = 0.0;
  MeasurementChainOptions chain = {};
  bool relative_noise = false;  ///< `noise` is a part of the channel's rms
};

/// {"a3": acceleration("body.2", noise=0.3)} in the order of the dictionary. Noise that is a part of the channel's rms
/// is zero: set_relative_noise() knows the channels.
std::vector<SensorDescription> sensors_of(const py::dict& sensors);
/// Noise that is a part of the rms of the sensor's row in the record.
void set_relative_noise(const py::dict& sensors, const Record& record, std::vector<SensorDescription>& all);
/// Throws InvalidInput where a sensor's noise is a part of its channel's rms, and there is no channel.
void refuse_relative_noise(const py::dict& sensors);
/// The other direction.
py::dict sensors_in_python(const std::vector<SensorDescription>& sensors);
/// The name of the function of Python that makes a sensor of it.
std::string quantity_name(ObservedQuantity quantity);
/// The same as quantities to estimate.
std::vector<OutputRequest> outputs_of(const py::dict& outputs);

/// 0.5 of "50 %"; nothing where the text is no percentage.
std::optional<double> percentage_of(const py::handle& given);

/// A number in SI, or a text with a unit: "3 mm". Throws InvalidInput with the argument's name, and where the unit has
/// another dimension than the given one. Of an empty one nothing is known.
double number_of(const py::handle& given, const std::string& unit, const std::string& argument);

}  // namespace kalfem::python
