#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"

namespace kalfem {

/// What to simulate.
struct SimulateOptions {
  std::vector<SensorDescription> sensors;
  double duration = 1.0;                   ///< from time 0 [s]
  double sample_rate = 1000.0;             ///< of the record [Hz]
  double tolerance = 1e-3;                 ///< relative change of every sensor's record when the step is halved
  std::optional<std::uint64_t> seed = {};  ///< of the sensors' noise; nothing: the record is free of noise
};

/// The record of a structure that starts at rest under its inputs: what the sensors show, by their names. Throws
/// InvalidInput with every argument that is wrong, and where the simulation stops: its time and reason.
Record simulate(const Structure& structure, const SimulateOptions& options);

}  // namespace kalfem
