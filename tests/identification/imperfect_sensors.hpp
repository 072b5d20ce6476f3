// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"

// The chain's record as imperfect sensors make it.

namespace kalfem::test {

/// recorded(t) = gain signal(t - delay) + offset + noise
struct SensorFault {
  double gain = 1.0, offset = 0.0;
  int delay = 0;  ///< in quarters of a sample, which the simulation holds
};

/// The sensors' signals four times a sample.
inline Eigen::MatrixXd fine_chain_signals(const EstimationProblem& problem, double duration) {
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : problem.sensors) outputs.push_back(sensor.output);
  const CoupledModel model = couple(problem.structure->reference_parts());
  SimulationOptions options;
  options.step = 0.25 / chain_rate;
  options.keep_every = 1;
  options.duration = duration;
  options.every_sample = make_outputs(model, outputs);
  return simulate(model.system(), problem.structure->signals, initial_state(InitialMotion{}, model), options)
      .every_sample;
}

/// `faults`: one a sensor. The noise is that of the sensor as recorded.
inline Record faulty_record(const EstimationProblem& problem, const Eigen::MatrixXd& fine,
                            const std::vector<SensorFault>& faults, std::uint64_t seed) {
  using Eigen::Index;
  const Index samples = (fine.cols() - 1) / 4 + 1;
  Record record{.sample_rate = problem.sample_rate, .values = Eigen::MatrixXd(fine.rows(), samples)};
  for (std::size_t i = 0; i < problem.sensors.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& [gain, offset, delay] = faults[i];
    const double noise = problem.sensors[i].deviation(rms(fine.row(row).transpose()));
    record.channels.push_back({problem.sensors[i].name, problem.sensors[i].unit, noise});
    RandomStream random(seed, problem.sensors[i].name);
    for (Index k = 0; k < samples; ++k)
      record.values(row, k) = gain * fine(row, std::max<Index>(0, 4 * k - delay)) + offset + noise * random.normal();
  }
  return record;
}

inline LikelihoodUnknown unknown_gain(const std::string& sensor, double deviation) {
  return {"sensors." + sensor + ".gain", LikelihoodUnknownKind::sensor_gain, {sensor}, "-", 1.0, deviation};
}
inline LikelihoodUnknown unknown_delay(const std::string& sensor, double deviation) {
  return {"sensors." + sensor + ".delay", LikelihoodUnknownKind::sensor_delay, {sensor}, "s", 0.0, deviation};
}
/// One clock of several sensors.
inline LikelihoodUnknown unknown_drift(const std::vector<std::string>& sensors, double deviation) {
  return {"sensors.rack.drift", LikelihoodUnknownKind::sensor_drift, sensors, "-", 0.0, deviation};
}

}  // namespace kalfem::test
