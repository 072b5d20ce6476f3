// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/base/progress.hpp"

namespace kalfem {

/// Settings of a simulation.
struct SimulateOptions {
  std::vector<SensorDescription> sensors;
  double duration = 1.0;                   ///< from time 0 [s]
  double sample_rate = 1000.0;             ///< of the record [Hz]
  double tolerance = 1e-3;                 ///< relative change of every sensor's record when the step is halved
  std::optional<std::uint64_t> seed = {};  ///< of the sensors' noise; if empty, the record is free of noise
  Progress progress = {};
};

/// Why and when a simulation stopped.
struct SimulationStop {
  double time = 0.0;   ///< [s]
  std::string reason;  ///< in words
};

/// What the sensors show, by their names. After a stop the record has its channels, but no samples.
struct SimulateResult {
  Record record;
  std::optional<SimulationStop> failure;  ///< nothing: it ran to the end

  [[nodiscard]] bool usable() const { return !failure; }
};

/// Simulates a structure that starts at rest under its inputs. Throws InvalidInput with every argument that is wrong;
/// what the numbers do is in the result.
SimulateResult simulate(const Structure& structure, const SimulateOptions& options);

/// Adds white noise of the sensors' standard deviations to their rows of a record, as simulate() does with that seed.
void add_noise(const std::vector<SensorDescription>& sensors, std::uint64_t seed, Record& record);

}  // namespace kalfem
