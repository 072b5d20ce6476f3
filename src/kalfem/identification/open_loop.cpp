// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/open_loop.hpp"

#include <algorithm>

#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// A simulation this many times larger than the record has diverged.
constexpr double diverged = 1e6;

}  // namespace

ConvergedSolution simulate_open_loop(const OpenLoopModel& model, const InitialState& initial, const Record& record) {
  std::vector<SignalPtr> signals;  // with the record's first sample at time 0
  for (const auto& signal : model.signals) signals.push_back(delayed(signal, -record.start));
  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : model.sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
  }
  SimulationOptions options;
  options.integrator = Integrator::exact;
  options.duration = static_cast<double>(record.samples() - 1) / record.sample_rate;
  return simulate_converged(model.system, signals, initial, make_outputs(model.points, outputs), chains, options,
                            {.sample_rate = record.sample_rate, .first_substeps = 1, .max_substeps = 64});
}

std::string open_loop_failure(const ConvergedSolution& simulated, const Record& measured, const std::string& what) {
  if (const auto& failure = simulated.simulation.failure)
    return what + " stopped at " + shortest(measured.start + failure->time) + " s: " + failure->reason;
  for (Index j = 0; j < simulated.sensors.rows(); ++j) {
    const double largest = simulated.sensors.row(j).cwiseAbs().maxCoeff();
    const auto record = measured.values.row(j).array();
    const double recorded = record.isFinite().select(record.abs(), 0.0).maxCoeff();
    if (!simulated.sensors.row(j).allFinite() || largest > diverged * std::max(recorded, 1e-300))
      return what + " exceeds a million times the record of '" + measured.channels[static_cast<std::size_t>(j)].name +
             "': the estimated structure is unstable";
  }
  return "";
}

}  // namespace kalfem
