// SPDX-License-Identifier: Apache-2.0
// A connector law of one's own, as a function of deformation and rate, and the estimate of its parameters.
#include <cmath>
#include <iostream>

#include "kalfem/kalfem.hpp"

using namespace kalfem;

/// A mount whose rubber stiffens: f = k x + k3 x^3 + c v.
double rubber(double x, double v, std::span<const double> p) { return p[0] * x + p[1] * x * x * x + p[2] * v; }

Structure engine_on_mount(double k3) {
  Structure s;
  s.add(lumped("engine").mass("m", 2.0));
  s.connect("mount", "engine.m", "ground", law("rubber", {{"k", 2e3}, {"k3", k3}, {"c", 8.0}}, rubber));
  Eigen::VectorXd force(4001);  // [N], 1 kHz
  for (Eigen::Index i = 0; i < force.size(); ++i) {
    const double t = 1e-3 * i;
    force[i] = 20 * std::sin(2 * 3.14159 * (3 + 2 * t) * t);
  }
  s.force("push", "engine.m", {force, 1000.0});
  return s;
}

int main() try {
  const std::vector<SensorDescription> sensors = {{"a", acceleration("engine.m"), 1.0}};
  const auto record = simulate(engine_on_mount(5e7), {.sensors = sensors, .duration = 3.9, .seed = 3}).record;
  const auto result = estimate(engine_on_mount(3e7), record,
                               {.sensors = sensors,
                                .unknowns = {{"mount.k3", {.std = 2e7}}, {"mount.c", {.initial = 5, .std = 3}}},
                                .outputs = {{"force", connector_force("mount")}}});
  for (const auto& p : result.parameters) std::cout << p.name << ' ' << p.mean << " +- " << p.std << '\n';
  std::cout << "largest force in the mount " << result.output("force").mean.maxCoeff() << " N\n";
  const auto &k3 = result.parameter("mount.k3"), &c = result.parameter("mount.c");
  return result.usable() && std::abs(k3.mean - 5e7) < 3 * k3.std && std::abs(c.mean - 8) < 3 * c.std ? 0 : 1;
} catch (const InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
