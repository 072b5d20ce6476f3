// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/system/sensors/measurement_chain.hpp"
#include "kalfem/system/sensors/output_description.hpp"

namespace kalfem {

/// Motion of a point, measured or requested: absolute, in global axes.
OutputDescription displacement(const std::string& point);  ///< [m]
OutputDescription velocity(const std::string& point);      ///< [m/s]
OutputDescription acceleration(const std::string& point);  ///< [m/s^2]
/// Quantities of a connector, measured or requested.
OutputDescription connector_force(const std::string& connector);        ///< [N]
OutputDescription connector_deformation(const std::string& connector);  ///< [m]
OutputDescription connector_rate(const std::string& connector);         ///< [m/s]
/// Strain of a gauge of finite elements, FiniteElements::gauge().
OutputDescription strain(const std::string& gauge);  ///< [m/m]

/// A sensor: {"a3", acceleration("body.2"), 0.3}.
struct SensorDescription {
  std::string name;  ///< of the record's channel
  OutputDescription output;
  double noise = 0.0;                  ///< standard deviation of its white noise [unit of the output]; > 0 for a filter
  MeasurementChainOptions chain = {};  ///< filters, delay, roll-off and gain between the motion and the sample
};

/// A quantity to estimate without a sensor for it: a virtual sensor.
struct OutputRequest {
  std::string name;
  OutputDescription output;
};

}  // namespace kalfem
