// SPDX-License-Identifier: Apache-2.0
#include "modal/ambient_updating.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/api/vibration.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "modal/ambient_record.hpp"

namespace kalfem::test {
namespace {

constexpr int storeys = 4;
constexpr double storey_stiffness = 12e6, floor_mass = 20e3;  // [N/m], [kg]
constexpr double sample_rate = 25.0, minutes = 20.0, damping = 0.01;

Structure frame(const Eigen::VectorXd& stiffnesses) {
  auto part = lumped("frame");
  for (int i = 0; i < storeys; ++i) {
    const std::string floor = std::to_string(i + 1), below = i == 0 ? "ground" : std::to_string(i);
    part = part.mass(floor, floor_mass).spring("storey_" + floor, below, floor, stiffnesses[i]);
  }
  Structure structure;
  structure.add(part);
  return structure;
}

/// White forces of the same strength at each floor, velocities of all floors.
AmbientStructure ambient(const Structure& structure) {
  const auto of_structure = modes(structure);
  return {.omega = 2.0 * std::numbers::pi * of_structure.frequencies,
          .zeta = Eigen::VectorXd::Constant(storeys, damping),
          .shapes = of_structure.shapes,
          .inputs = of_structure.shapes.transpose()};
}

}  // namespace

UpdatingTally update_from_records(int first, int count) {
  UpdatingTally tally;
  std::vector<std::pair<std::string, std::string>> points;
  UpdateOptions options;
  for (int i = 1; i <= storeys; ++i) {
    points.emplace_back("frame." + std::to_string(i), "v" + std::to_string(i));
    options.parameters.push_back({"frame.storey_" + std::to_string(i) + ".stiffness"});
  }
  const Structure model = frame(Eigen::VectorXd::Constant(storeys, storey_stiffness));
  for (int seed = first; seed < first + count; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed), "stiffnesses");
    Eigen::VectorXd truth(storeys);
    for (auto& stiffness : truth) stiffness = storey_stiffness * (0.75 + 0.5 * random.uniform());
    const auto record =
        ambient_record(ambient(frame(truth)), sample_rate, static_cast<Eigen::Index>(60.0 * minutes * sample_rate),
                       static_cast<std::uint64_t>(seed));
    options.comparisons = {{"ambient", measured_modes(mode_set(identify_modes(record)), "frame", points)}};
    const auto found = update(model, options);
    ++tally.records;
    tally.consistent += found.verdict.state() == VerdictState::consistent;
    for (int i = 0; i < storeys; ++i) {
      const auto& each = found.parameters[static_cast<std::size_t>(i)];
      const double error = (each.value - truth[i]) / each.std;
      ++tally.intervals;
      tally.held += each.interval_95.lower <= truth[i] && truth[i] <= each.interval_95.upper;
      tally.largest_std = std::max(tally.largest_std, each.std / truth[i]);
      tally.mean_square += (error * error - tally.mean_square) / tally.intervals;
    }
  }
  return tally;
}

}  // namespace kalfem::test
