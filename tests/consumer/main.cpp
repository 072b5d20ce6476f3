// A program of somebody else: one mass on a spring, its free vibration against the closed form.
#include <cmath>
#include <cstdio>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"

int main() {
  kalfem::LumpedSubstructure part;
  part.name = "oscillator";
  part.masses = {{"m", 2.0}};
  part.springs = {{"k", "ground", "m", 800.0, 0.0}};
  const kalfem::CoupledModel model({{"oscillator", kalfem::assemble(part)}}, {}, {});
  auto start = kalfem::at_rest(1, 0);
  start.displacement[0] = 1.0;
  const auto result = kalfem::simulate(model.system(), {}, start,
                                       {.integrator = kalfem::Integrator::exact, .step = 0.1, .duration = 1.0});
  const double error = std::abs(result.trajectory.displacement(0, 10) - std::cos(20.0));
  std::printf("error %.1e\n", error);
  return error < 1e-12 ? 0 : 1;
}
