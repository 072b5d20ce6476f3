// SPDX-License-Identifier: Apache-2.0
// A filter step by step, as a live system needs it: predict with the force just applied, update with the sample just
// measured, and use the estimates at once.
#include <cmath>
#include <iostream>

#include "kalfem/kalfem.hpp"

using namespace kalfem;

/// Two masses on springs, and a stop that stiffens.
Structure two_masses(double k3) {
  Structure s;
  s.add(lumped("table")
            .mass("a", 5)
            .mass("b", 3)
            .spring("foot", "ground", "a", 4e4, 20)
            .spring("rod", "a", "b", 2e4, 10));
  s.connect("stop", "table.b", "ground", law("polynomial", {{"k1", 1e3}, {"k3", k3}}));
  return s;
}

int main() try {
  const double rate = 500.0;
  const Eigen::Index samples = 1500;
  const std::vector<SensorDescription> sensors = {{"a", acceleration("table.a"), 0.1},
                                                  {"b", acceleration("table.b"), 0.1}};

  // What would come from the converter: a record of the same structure with a stop of 4e8 N/m^3.
  Eigen::VectorXd force(samples);
  for (Eigen::Index k = 0; k < samples; ++k) force[k] = 30 * std::sin(2 * 3.14159 * (2 + k / rate) * k / rate);
  Structure truth = two_masses(4e8).force("shaker", "table.b", {force, rate});
  const auto live = simulate(truth, {.sensors = sensors, .duration = 2.99, .sample_rate = rate, .seed = 5}).record;

  Structure model = two_masses(2e8).force("shaker", "table.b");  // its force is told sample by sample
  OnlineFilter filter(model, rate, {.sensors = sensors, .unknowns = {{"stop.k3", {.std = 2e8}}}});
  filter.update(live.values.col(0));
  for (Eigen::Index k = 1; k < live.samples() && filter.running(); ++k) {
    filter.predict({{.value = force[k]}});
    filter.update(live.values.col(k));
    if (k % 300 == 0)
      std::cout << filter.time() << " s: displacement of b " << filter.state("table.b.displacement").mean
                << " m, stop.k3 " << filter.parameter("stop.k3").mean << " N/m^3\n";
  }
  const auto k3 = filter.parameter("stop.k3");
  return filter.usable() && std::abs(k3.mean - 4e8) < 3 * k3.std && k3.std < 5e7 ? 0 : 1;
} catch (const InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
