#include "kalfem/identification/simulation_residual.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/updating/parallel_columns.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SimulationResidual::SimulationResidual(StructurePtr given, std::vector<Sensor> measured, const FullRecord& record,
                                       std::shared_ptr<const ParameterisedStructure> structure,
                                       std::vector<UpdatingParameter> parameters, Options options)
    : given_(std::move(given)),
      structure_(std::move(structure)),
      options_(std::move(options)),
      sensors_(std::move(measured)),
      parameters_(std::move(parameters)),
      start_(record.series.start),
      sample_rate_(record.series.sample_rate) {
  settled_ = std::min(static_cast<Index>(std::llround(options_.settle * sample_rate_)), record.series.samples() - 1);
  measured_.resize(record.series.samples() - settled_, static_cast<Index>(sensors_.size()));
  noise_.resize(measured_.cols());
  for (Index j = 0; j < measured_.cols(); ++j) {
    const Index channel = record.series.find(sensors_[static_cast<std::size_t>(j)].name);
    measured_.col(j) = record.series.values.col(channel).tail(measured_.rows());
    noise_[j] = record.noise[static_cast<std::size_t>(channel)];
    if (!(noise_[j] > 0.0))
      throw InvalidInput("sensor '" + sensors_[static_cast<std::size_t>(j)].name + "' has no noise",
                         "the residual is measured in standard deviations of the noise", "give the sensor a noise");
  }
}

std::optional<VectorXd> SimulationResidual::values(const StructureParts& parts) const {
  const CoupledModel model = couple(parts);
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : sensors_) outputs.push_back(sensor.output);
  const double fine_rate = sample_rate_ * static_cast<double>(options_.substeps);
  SimulationOptions simulation;
  simulation.integrator = Integrator::exact;
  simulation.step = 1.0 / fine_rate;
  simulation.duration = static_cast<double>(settled_ + measured_.rows() - 1) / sample_rate_;
  simulation.keep_motion = false;
  simulation.every_step = make_outputs(model, outputs);
  std::vector<SignalPtr> signals;
  for (const auto& signal : given_->signals) signals.push_back(delayed(signal, -start_));
  const auto result = simulate(model.system(), signals, initial_state(options_.initial, model), simulation);
  if (result.failure) return std::nullopt;
  MatrixXd residual(measured_.rows(), measured_.cols());
  for (Index j = 0; j < measured_.cols(); ++j) {
    const VectorXd fine = sensors_[static_cast<std::size_t>(j)].chain.filter(result.every_step.col(j), fine_rate);
    const VectorXd sampled = fine(Eigen::seqN(settled_ * options_.substeps, measured_.rows(), options_.substeps));
    const VectorXd difference = (sampled - measured_.col(j)) / noise_[j];
    residual.col(j) = difference.array().isNaN().select(0.0, difference);
  }
  return VectorXd(residual.reshaped());
}

std::optional<ResidualValue> SimulationResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const try {
  const StructureAtParameters here = structure_->at(parameters);
  auto residual = values(here.parts);
  if (!residual) return std::nullopt;
  ResidualValue value{std::move(*residual), {}};
  if (!with_jacobian) return value;
  auto jacobian =
      parallel_columns(value.values.size(), parameters.size(), processors(), [&](Index i) -> std::optional<VectorXd> {
        const double step = options_.relative_step * parameters_[static_cast<std::size_t>(i)].scale();
        const VectorXd moved = parameters + step * VectorXd::Unit(parameters.size(), i);
        auto beside = values(structure_->near(here, moved));
        if (beside) *beside = (*beside - value.values) / step;
        return beside;
      });
  if (!jacobian) return std::nullopt;
  value.jacobian = std::move(*jacobian);
  return value;
} catch (const InvalidInput&) {
  return std::nullopt;
}

}  // namespace kalfem
