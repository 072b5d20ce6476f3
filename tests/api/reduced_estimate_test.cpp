// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

// Estimates of finite elements that move far from the values at which the elements were reduced.

namespace kalfem {
namespace {

constexpr double rate = 1000.0;

/// A cantilever whose outer half is of another material, reduced to its tip and one mode.
Structure beam_of_two_materials(double outer_modulus) {
  FiniteElementModel model = beam_mesh(5);
  model.materials["steel"] = {210e9, 0.3, 7850.0};
  model.materials["outer"] = {outer_modulus, 0.3, 7850.0};
  model.properties["bar"] = BeamProperty{"steel", rectangular_section(0.02, 0.01)};
  model.properties["outer"] = BeamProperty{"outer", rectangular_section(0.02, 0.01)};
  Structure s;
  s.add(FiniteElements("beam", model)
            .node("root", 1)
            .node("tip", 11)
            .fix("root")
            .modal_damping({0.02}, 400.0)
            .reduce({.modes = {.count = 1}}));
  s.connect("stop", "beam.tip.z", "ground", law("polynomial", {{"k1", 1e3}, {"k3", 1e8}}));
  Eigen::VectorXd push(301);
  for (Eigen::Index k = 0; k < push.size(); ++k) {
    const double t = static_cast<double>(k) / rate;
    push[k] = 5.0 * std::sin(2.0 * EIGEN_PI * (5.0 + 130.0 * t) * t);
  }
  return s.force("push", "beam.tip.z", {push, rate});
}

const std::vector<SensorDescription> tip = {{"tip", acceleration("beam.tip.z"), 0.1}};

double estimated_modulus(double initial, const Record& record) {
  const auto result =
      estimate(beam_of_two_materials(initial), record,
               {.sensors = tip, .unknowns = {{"beam.outer.youngs_modulus", {.std = 60e9}}}, .diagnose = false});
  EXPECT_FALSE(result.failure);
  return result.parameters[0].mean;
}

TEST(ReducedEstimate, DoesNotDependOnTheValuesOfTheFirstReduction) {
  const auto record =
      simulate(beam_of_two_materials(100e9), {.sensors = tip, .duration = 0.3, .sample_rate = rate, .seed = 1}).record;
  const double near = estimated_modulus(101e9, record), far = estimated_modulus(160e9, record);
  EXPECT_NEAR(far, near, 1e-3 * near);
}

}  // namespace
}  // namespace kalfem
