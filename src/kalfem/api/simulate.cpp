// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/simulate.hpp"

#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/dynamics/converged_solution.hpp"

namespace kalfem {

using Eigen::Index;

void add_noise(const std::vector<SensorDescription>& sensors, std::uint64_t seed, Record& record) {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    RandomStream random(seed, sensors[i].name);
    for (auto& value : record.values.row(static_cast<Index>(i))) value += sensors[i].noise * random.normal();
  }
}

SimulateResult simulate(const Structure& structure, const SimulateOptions& options) {
  require_signals(structure.description());
  const auto model = make_structure_model(structure.description());
  const CoupledModel coupled = couple(model->reference_parts());
  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  Record record{.sample_rate = options.sample_rate, .start = 0.0, .channels = {}, .values = {}};
  for (const auto& sensor : options.sensors) {
    outputs.push_back(sensor.output);
    outputs.back().name = sensor.name;
    chains.emplace_back(sensor.chain);
    record.channels.push_back({sensor.name, unit_of(sensor.output.quantity), options.seed ? sensor.noise : 0.0});
  }
  record.values.resize(static_cast<Index>(options.sensors.size()), 0);
  SimulationOptions simulation;
  simulation.duration = options.duration;
  simulation.keep_motion = false;
  simulation.progress = options.progress;
  const auto& system = coupled.system();
  auto solution = simulate_converged(system, model->signals, at_rest(system.size(), system.connector_states()),
                                     make_outputs(coupled, outputs), chains, simulation,
                                     {.sample_rate = options.sample_rate, .tolerance = options.tolerance});
  if (const auto& failure = solution.simulation.failure)
    return {std::move(record), SimulationStop{failure->time, failure->reason}};
  record.values = std::move(solution.sensors);
  if (options.seed) add_noise(options.sensors, *options.seed, record);
  return {std::move(record), std::nullopt};
}

}  // namespace kalfem
