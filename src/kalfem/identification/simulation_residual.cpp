// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/simulation_residual.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/updating/difference_jacobian.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SimulationResidual::SimulationResidual(StructurePtr given, std::vector<Sensor> measured, const Record& record,
                                       std::shared_ptr<const ParameterisedStructure> structure,
                                       std::vector<UpdatingParameter> parameters, Options options)
    : given_(std::move(given)),
      structure_(std::move(structure)),
      options_(std::move(options)),
      sensors_(std::move(measured)),
      parameters_(std::move(parameters)),
      start_(record.start),
      sample_rate_(record.sample_rate) {
  settled_ = std::min(static_cast<Index>(std::llround(options_.settle * sample_rate_)), record.samples() - 1);
  measured_.resize(static_cast<Index>(sensors_.size()), record.samples() - settled_);
  noise_.resize(measured_.rows());
  for (Index j = 0; j < measured_.rows(); ++j) {
    const Index channel = record.find(sensors_[static_cast<std::size_t>(j)].name);
    measured_.row(j) = record.values.row(channel).tail(measured_.cols());
    noise_[j] = record.channels[static_cast<std::size_t>(channel)].noise;
    if (!(noise_[j] > 0.0))
      throw InvalidInput("sensor '" + sensors_[static_cast<std::size_t>(j)].name + "' has no noise",
                         "the residual is measured in standard deviations of the noise", "give the sensor a noise");
  }
}

// Simulates by exact stepping with `substeps` steps per sample, passes each output through the chain of its sensor at
// this rate, and takes the samples of the record after settling.
std::optional<MatrixXd> SimulationResidual::simulated(const StructureParts& parts,
                                                      const std::vector<SignalPtr>& given) const {
  const CoupledModel model = couple(parts);
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : sensors_) outputs.push_back(sensor.output);
  const double fine_rate = sample_rate_ * static_cast<double>(options_.substeps);
  SimulationOptions simulation;
  simulation.integrator = Integrator::exact;
  simulation.step = 1.0 / fine_rate;
  simulation.duration = static_cast<double>(settled_ + measured_.cols() - 1) / sample_rate_;
  simulation.keep_motion = false;
  simulation.every_step = make_outputs(model, outputs);
  std::vector<SignalPtr> signals;
  for (const auto& signal : given) signals.push_back(delayed(signal, -start_));
  const auto result = simulate(model.system(), signals, initial_state(options_.initial, model), simulation);
  if (result.failure) return std::nullopt;
  MatrixXd channels(measured_.rows(), measured_.cols());
  for (Index j = 0; j < measured_.rows(); ++j) {
    const VectorXd fine =
        sensors_[static_cast<std::size_t>(j)].chain.filter(result.every_step.row(j).transpose(), fine_rate);
    const VectorXd sampled = fine(Eigen::seqN(settled_ * options_.substeps, measured_.cols(), options_.substeps));
    channels.row(j) = sampled.transpose();
  }
  return channels;
}

/// Sensor by sensor, in standard deviations. Missing samples are zero.
VectorXd SimulationResidual::over_noise(const MatrixXd& channels) const {
  const MatrixXd rows = (noise_.cwiseInverse().asDiagonal() * channels).transpose();
  const MatrixXd present = measured_.transpose();
  return present.array().isNaN().select(0.0, rows).reshaped();
}

std::optional<VectorXd> SimulationResidual::values(const StructureParts& parts) const {
  const auto channels = simulated(parts, given_->signals);
  return channels ? std::optional(over_noise(*channels - measured_)) : std::nullopt;
}

StructureParts SimulationResidual::parts_at(const StructureAtParameters& here, const VectorXd& parameters) const {
  StructureParts parts = structure_->near(here, parameters);
  for (const auto& [index, parameter] : options_.connectors) set_parameter(parts, parameter, parameters[index]);
  return parts;
}

std::vector<ComparedGain> SimulationResidual::gains() const {
  std::vector<ComparedGain> all;
  for (const auto& sensor : sensors_) all.push_back({sensor.name + ".gain", false});
  for (const auto& input : given_->parts.inputs) all.push_back({input.name + ".gain", true});
  return all;
}

/// An excitation's by a difference, as the structure may not be linear.
std::optional<MatrixXd> SimulationResidual::by_gains(const VectorXd& parameters) const try {
  const StructureParts parts = parts_at(structure_->at(parameters), parameters);
  const auto channels = simulated(parts, given_->signals);
  if (!channels) return std::nullopt;
  MatrixXd by = MatrixXd::Zero(size(), std::ssize(gains()));
  for (Index j = 0; j < channels->rows(); ++j) {
    MatrixXd own = MatrixXd::Zero(channels->rows(), channels->cols());
    own.row(j) = -channels->row(j);
    by.col(j) = over_noise(own);
  }
  for (std::size_t i = 0; i < given_->signals.size(); ++i) {
    auto signals = given_->signals;
    signals[i] = scaled(signals[i], 1.0 + options_.relative_step);
    const auto beside = simulated(parts, signals);
    if (!beside) return std::nullopt;
    by.col(channels->rows() + static_cast<Index>(i)) = over_noise((*beside - *channels) / options_.relative_step);
  }
  return by;
} catch (const InvalidInput&) {
  return std::nullopt;
}

// The Jacobian is by differences: two simulations per parameter, in parallel, with the finite elements in the bases of
// `parameters`.
std::optional<ResidualValue> SimulationResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const try {
  const StructureAtParameters here = structure_->at(parameters);
  auto residual = values(parts_at(here, parameters));
  if (!residual) return std::nullopt;
  ResidualValue value{std::move(*residual), {}};
  if (!with_jacobian) return value;
  auto jacobian = difference_jacobian(parameters_, parameters, value.values, options_.relative_step, processors(),
                                      [&](const VectorXd& beside) { return values(parts_at(here, beside)); });
  if (!jacobian) return std::nullopt;
  value.jacobian = std::move(*jacobian);
  return value;
} catch (const InvalidInput&) {
  return std::nullopt;
}

}  // namespace kalfem
