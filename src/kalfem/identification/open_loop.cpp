// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/open_loop.hpp"

#include <algorithm>
#include <limits>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

namespace {

/// The augmented model's system at the estimated parameters.
LocallyNonlinearSystem estimated_system(const RecordEstimate& estimate) {
  const auto& options = estimate.augmented_model->options();
  const VectorXd estimates = estimate.result.unknowns.mean.rightCols(1);
  const auto linear = linear_unknowns(options);
  LocallyNonlinearSystem system =
      linear.empty() ? estimate.augmented_model->system() : options.system_at(estimates(linear));
  const auto& unknowns = options.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          estimates[static_cast<Index>(i)];
  return system;
}

/// Simulates the record from the estimated parameters and initial state, without any correction by measurements. Adds
/// the offsets that the sensors show in addition to the motion.
ConvergedSolution simulate_record_again(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                        const RecordEstimate& estimate) {
  const auto& layout = estimate.augmented_model->layout();
  const Index last = estimate.result.state.mean.cols() - 1;
  const VectorXd start = estimate.result.state.mean.col(last).segment(layout.initial_state(), layout.linear);
  const VectorXd states = estimate.result.state.mean.col(last).tail(layout.connector_states);
  const LocallyNonlinearSystem system = estimated_system(estimate);
  ConvergedSolution reference = simulate_open_loop(
      {system, *setup.model, setup.sensors, problem.structure->signals},
      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states}, estimate.measurements);
  if (reference.sensors.size() == 0) return reference;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors)
      reference.sensors.row(sensor).array() += estimate.result.unknowns.mean(static_cast<Index>(i), last);
  return reference;
}

void compare_open_loop(const MatrixXd& simulated, RecordEstimate& estimate) {
  const Index samples = estimate.measurements.samples();
  const Index tail = std::max<Index>(1, samples / 20);  // where the structure rests at the end
  for (Index j = 0; j < simulated.rows(); ++j) {
    const VectorXd measured = estimate.measurements.values.row(j);
    const auto missing = measured.array().isNaN();
    const VectorXd end = measured.tail(tail), known = end.array().isNaN().select(0.0, end);
    const double rest = known.sum() / std::max(1.0, static_cast<double>((!end.array().isNaN()).count()));
    const VectorXd error = missing.select(0.0, simulated.row(j).transpose() - measured);
    const VectorXd about_rest = missing.select(0.0, measured.array() - rest);
    const double scale = rms(about_rest);
    estimate.open_loop_nrmse.push_back(scale > 0.0 ? rms(error) / scale : std::numeric_limits<double>::infinity());
    estimate.open_loop_rest_error.push_back(simulated.row(j).tail(tail).mean() - rest);
  }
}

}  // namespace

void set_open_loop(const EstimationProblem& problem, const AugmentedModelSetup& setup, RecordEstimate& estimate) {
  ConvergedSolution reference = simulate_record_again(problem, setup, estimate);
  estimate.open_loop_failure = open_loop_failure(reference, estimate.measurements, "the simulation with the estimates");
  if (!estimate.open_loop_failure.empty()) return;
  estimate.open_loop = std::move(reference.simulation);
  estimate.open_loop_sensors = std::move(reference.sensors);
  compare_open_loop(estimate.open_loop_sensors, estimate);
}

}  // namespace kalfem
