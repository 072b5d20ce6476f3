// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem {

/// Simulates the structure until a finer step does not change the sensors' records, and makes the record with noise.
/// `failure` says in words why there is none.
SimulationOutcome run_simulation(const Study& study, const Progress& progress, std::string& failure);

/// Makes the record from the reference: adds white noise by `seed`, in place of any noise that it has. Each sensor has
/// its own random stream, so a further sensor does not change the others.
void add_noise(const Study& study, std::uint64_t seed, SimulationOutcome& outcome);

}  // namespace kalfem
