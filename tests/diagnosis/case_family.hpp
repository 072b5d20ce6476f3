// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem::test {

/// A structure that is measured and then estimated from files, as a case of a user is, so that mistakes can be put
/// between the two.
struct CaseFamily {
  std::string name;
  std::string structure;  ///< the sections `substructures` and `connectors`
  /// Name, what it drives ("base_displacement: wheel.ground"), its signal ("random: {...}").
  struct Excitation {
    std::string name, drives, signal;
  };
  std::vector<Excitation> excitations;
  struct MeasuredPoint {
    std::string name, quantity, unit;  ///< "a3", "acceleration: body.2", "m/s^2"
    std::string more = "";             ///< ", chain: [...]"
  };
  std::vector<MeasuredPoint> sensors;
  double noise = 0.05;   ///< of each channel's rms
  std::string simulate;  ///< keys of the section beside duration and sample_rate
  double duration = 8.0, sample_rate = 1000.0;
  std::string estimate;  ///< the section
};

/// Files of one measurement: sensors, and what drove the structure.
struct Measurement {
  Record sensors;
  Record excitations;  ///< four samples of these in each of the sensors'
};

/// Simulates the family's structure; `changed` replaces texts of its structure first.
using Changes = std::vector<std::pair<std::string, std::string>>;
Measurement measure(const CaseFamily& family, const Changes& changes, int seed, const std::filesystem::path& folder);

/// Writes the files and the case that estimates from them; returns the case's path.
std::filesystem::path write_case(const CaseFamily& family, const Measurement& measurement, const Changes& changes,
                                 const std::filesystem::path& folder);

/// The families: the chain of the examples, a half car, a frame on a shaking table, the vehicle on its coarse mesh.
CaseFamily chain_family();
CaseFamily half_car_family();
CaseFamily frame_family();
CaseFamily vehicle_family();

}  // namespace kalfem::test
