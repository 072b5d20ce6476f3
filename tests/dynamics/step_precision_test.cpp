// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int side = 8;

std::string name_of(int x, int y, int z) {
  return std::to_string(x) + "_" + std::to_string(y) + "_" + std::to_string(z);
}

/// Springs between the neighbours of a cube of masses, so many that their factor is kept by supernodes; its lowest face
/// stands on soft springs, one corner on a saturating suspension over a road.
LocallyNonlinearSystem cube(double stiffness = 1e5) {
  LumpedSubstructure body;
  const auto join = [&](const std::string& from, const std::string& to, double k) {
    body.springs.push_back({"s" + std::to_string(body.springs.size()), from, to, k, 1e-4 * k});
  };
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) {
        body.masses.push_back({name_of(x, y, z), 0.01 * (1.0 + 0.05 * x)});
        if (x > 0) join(name_of(x - 1, y, z), name_of(x, y, z), stiffness);
        if (y > 0) join(name_of(x, y - 1, z), name_of(x, y, z), stiffness);
        if (z > 0) join(name_of(x, y, z - 1), name_of(x, y, z), stiffness);
        if (z == 0 && x > 2) join("ground", name_of(x, y, z), 2e4);
      }
  LumpedSubstructure wheel;
  wheel.masses = {{"w", 1.5}};
  wheel.springs = {{"tyre", "ground", "w", 2e4, 5.0}};
  return CoupledModel({{"wheel", assemble(wheel)}, {"body", assemble(body)}},
                      {{"suspension", "wheel.w", "body.0_0_0", make_law("saturating"), saturating_parameters()}},
                      {{"road", InputKind::base_displacement, "wheel.ground"}})
      .system();
}

/// Modal damping of the two lowest modes, which the dashpots join to all others: it stays a term of low rank.
LocallyNonlinearSystem with_modal_damping(LocallyNonlinearSystem system) {
  const auto modes = normal_modes(system.mass, system.stiffness);
  system.modal_damping = {{modes.frequencies.head(2), modes.shapes.leftCols(2)}, VectorXd::LinSpaced(2, 3.0, 5.0)};
  return system;
}

SimulationResult simulated(const LocallyNonlinearSystem& system, Integrator integrator, FactorPrecision precision) {
  const auto road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 0.5, .fade_in = 0.1, .seed = 7});
  return simulate(system, {road}, at_rest(system.size(), 0),
                  {.integrator = integrator, .step = 5e-4, .duration = 0.25, .precision = precision});
}

double difference(const SimulationResult& a, const SimulationResult& b) {
  double largest = 0.0;
  for (const auto motion :
       {&Trajectory::displacement, &Trajectory::velocity, &Trajectory::acceleration, &Trajectory::force})
    largest = std::max(largest, (a.trajectory.*motion - b.trajectory.*motion).norm() / (b.trajectory.*motion).norm());
  return largest;
}

TEST(StepPrecision, SinglePrecisionLeavesTheMotionAsItIs) {
  for (const auto& system : {cube(), with_modal_damping(cube())})
    for (const auto integrator : {Integrator::newmark, Integrator::hht_alpha, Integrator::generalized_alpha}) {
      const auto twofold = simulated(system, integrator, FactorPrecision::twofold);
      const auto single = simulated(system, integrator, FactorPrecision::single);
      EXPECT_EQ(twofold.solve_error, 0.0);
      EXPECT_GT(single.solve_error, 1e-9);
      EXPECT_LT(single.solve_error, 1e-5);
      EXPECT_LT(difference(single, twofold), 1e-6);
      EXPECT_GT(difference(single, twofold), 1e-15);  // it is another computation
    }
}

/// Between springs that a step cannot bend the masses' own motion is lost in single precision.
TEST(StepPrecision, DoublePrecisionStaysWhereSingleCannotSolve) {
  const auto system = cube(1e14);
  const auto asked_for = simulated(system, Integrator::newmark, FactorPrecision::single);
  EXPECT_EQ(asked_for.solve_error, 0.0);
  EXPECT_EQ(difference(asked_for, simulated(system, Integrator::newmark, FactorPrecision::twofold)), 0.0);
}

TEST(StepPrecision, SmallFactorsStayInDoublePrecision) {
  const auto system = cube();
  EXPECT_EQ(simulated(system, Integrator::newmark, FactorPrecision::automatic).solve_error, 0.0);
}

}  // namespace
}  // namespace kalfem
