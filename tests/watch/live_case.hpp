// SPDX-License-Identifier: Apache-2.0
// A quarter car on a road, as the case of a run, of a stream and of a simulation.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/scratch_folder.hpp"

namespace kalfem::live_case {

inline const std::string structure = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 40 kg}, springs: [{name: tyre, from: ground, to: w, stiffness: 180 kN/m, damping: 200}]}
  body: {masses: {b: 300 kg}}
connectors:
  strut: {from: wheel.w, to: body.b, law: polynomial, parameters: {k1: 20 kN/m, k3: 3e6, c1: 1200}}
)";

inline const std::string unknown = R"(
estimate:
  unknown: {strut.k3: {initial: 2e6, std: 2e6}}
)";

/// `live` of a stream from which a record would be read.
inline std::string live(const std::string& more = "", const std::string& sensors = R"(
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2})") {
  return structure + R"(excitation:
  road: {base_displacement: wheel.ground, file: live, channel: road}
sensors:)" +
         sensors + "\nlive: {sample_rate: 500 Hz, horizon: 0.5 s, every: 0.5 s" + (more.empty() ? "" : ", " + more) +
         "}\n" + unknown;
}

inline std::string simulated(double duration) {
  return structure + R"(excitation:
  road: {base_displacement: wheel.ground, random: {rms: 8 mm, band: [0.5, 12 Hz], seed: 4}}
sensors:
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2}
simulate: {duration: )" +
         std::to_string(duration) + " s, sample_rate: 500 Hz, tolerance: 1e-5, seed: 2}\n";
}

/// The run over what was published, as a table.
inline std::string recorded(const std::string& file) {
  return structure + R"(excitation:
  road: {base_displacement: wheel.ground, file: )" +
         file + R"(, channel: road}
sensors:
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2}
record: {file: )" +
         file + "}\n" + unknown;
}

inline std::string written(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return file.string();
}

/// Memory of this process that is not swapped out.
inline double resident_megabytes() {
  std::ifstream status("/proc/self/statm");
  double size = 0.0, resident = 0.0;
  status >> size >> resident;
  return resident * 4096.0 / 1e6;
}

}  // namespace kalfem::live_case
