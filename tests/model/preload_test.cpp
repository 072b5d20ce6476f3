// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/fe_models.hpp"
#include "model/preloaded.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

void hold(FiniteElementModel& model, const std::vector<Index>& nodes, const std::vector<int>& directions) {
  FixedNodes fixed{"support " + std::to_string(model.fixed.size() + 1), nodes, {}};
  fixed.directions.fill(false);
  for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
  model.fixed.push_back(fixed);
}

/// First natural frequency [Hz] under the stresses of a load case; negative where the load is beyond buckling.
double first_frequency(const FiniteElementModel& model, const LoadCase& preload) {
  const auto frequencies = preloaded_frequencies(model, preload, 1);
  return frequencies.size() > 0 ? frequencies[0] : -1.0;
}

/// Pinned at both ends, of a rectangle 20 mm wide and 5 mm high; the far end slides along x.
FiniteElementModel column(double length, int count, double inertia_factor = 1.0) {
  auto section = rectangular_section(0.02, 0.005);
  section.inertia_y *= inertia_factor;
  section.inertia_z *= inertia_factor;
  auto model = beam_model({length, 0.0, 0.0}, count, section);
  hold(model, {0}, {0, 1, 2, 3});
  hold(model, {count}, {1, 2});
  return model;
}

LoadCase along_x(Index node, double force) {
  return {.name = "axial", .loads = {{node, {force, 0.0, 0.0}, Vector3d::Zero()}}};
}

// f / f_0 = sqrt(1 + N / N_cr), N_cr = pi^2 E I / L^2 of a slender column.
TEST(Preload, TensionAndCompressionOfAPinnedBeam) {
  const auto model = column(1.0, 16);
  const double inertia = 0.02 * std::pow(0.005, 3) / 12.0, critical = pi * pi * steel.youngs_modulus * inertia;
  const double free = first_frequency(model, along_x(16, 1e-6));
  for (const double ratio : {-0.9, -0.5, 0.5, 3.0})
    EXPECT_NEAR(first_frequency(model, along_x(16, ratio * critical)), free * std::sqrt(1.0 + ratio),
                2e-3 * free * std::sqrt(1.0 + ratio))
        << ratio;
  EXPECT_GT(first_frequency(model, along_x(16, -0.995 * critical)), 0.0);
  EXPECT_LT(first_frequency(model, along_x(16, -1.005 * critical)), 0.0);
}

// f = sqrt(N / (rho A)) / (2 L) of a cable almost without bending stiffness.
TEST(Preload, TensionedCable) {
  const double force = 5e4, length = 10.0;
  const auto model = column(length, 40, 1e-6);
  const double expected = std::sqrt(force / (7850.0 * 1e-4)) / (2.0 * length);
  EXPECT_NEAR(first_frequency(model, along_x(40, force)), expected, 1e-3 * expected);
}

// Simply supported square plate under equal membrane forces n in both directions: omega^2 = omega_0^2 (1 + n / n_cr)
// with n_cr = 2 pi^2 D / a^2.
TEST(Preload, SimplySupportedPlateUnderMembraneForce) {
  for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3}) {
    const double t = 0.01;
    const int count = 24;
    ShellProblem problem(
        {count, count, shape},
        [](double u, double v) -> Vector3d {
          return {u, v, 0.0};
        },
        steel, t);
    std::vector<Index> edge;
    LoadCase pull{.name = "pull"};
    const double rigidity = steel.youngs_modulus * t * t * t / (12.0 * 0.91), critical = 2.0 * pi * pi * rigidity;
    for (const auto& [side, direction] : {std::pair{'u', 0}, {'v', 1}})
      for (const int end : {0, 1}) {
        const auto nodes = problem.grid.side(side, end);
        edge.insert(edge.end(), nodes.begin(), nodes.end());
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          Vector3d force = Vector3d::Zero();
          const double share = (i == 0 || i + 1 == nodes.size() ? 0.5 : 1.0) / count;
          force[direction] = (end == 0 ? -1.0 : 1.0) * critical * share;
          pull.loads.push_back({nodes[i], force, Vector3d::Zero()});
        }
      }
    hold(problem.model, edge, {2});
    hold(problem.model, {problem.grid.node(0, 0)}, {0, 1});
    hold(problem.model, {problem.grid.node(count, 0)}, {1});
    const auto scaled = [&](double factor) {
      LoadCase load = pull;
      for (auto& each : load.loads) each.force *= factor;
      return first_frequency(problem.model, load);
    };
    const double free = scaled(1e-9);
    for (const double ratio : {-0.7, 1.0}) EXPECT_NEAR(scaled(ratio) / free, std::sqrt(1.0 + ratio), 0.01) << ratio;
    EXPECT_LT(scaled(-1.05), 0.0);
  }
}

// A clamped bar of solids, 1 m long and 50 mm thick, against Euler's buckling load of a cantilever with shear.
TEST(Preload, CompressedColumnOfSolidsBuckles) {
  for (const auto shape : {CellShape::hexahedron8, CellShape::hexahedron20}) {
    SolidProblem problem(
        {16, 2, 2, shape},
        [](const Vector3d& cube) -> Vector3d {
          return {cube.x(), 0.05 * cube.y(), 0.05 * cube.z()};
        },
        steel);
    problem.fix(problem.box.side(0, 0.0), {0, 1, 2});
    const double inertia = std::pow(0.05, 4) / 12.0, euler = pi * pi * steel.youngs_modulus * inertia / 4.0;
    const auto end = faces_between_nodes(problem.model, problem.box.side(0, 1.0));
    const auto pressed = [&](double ratio) {
      return first_frequency(problem.model, {.name = "press", .pressures = {{end, ratio * euler / 0.0025}}});
    };
    EXPECT_GT(pressed(0.98), 0.0);
    EXPECT_LT(pressed(1.02), 0.0);
    EXPECT_NEAR(pressed(0.5) / pressed(0.0001), std::sqrt(0.5), 0.02);  // not quite linear: the shape changes
  }
}

}  // namespace
}  // namespace kalfem::test
