#include "kalfem/dynamics/reference.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/time_series.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd every(const MatrixXd& fine, Index substeps) { return fine(Eigen::seq(0, Eigen::last, substeps), Eigen::all); }

/// Passes the fine-step outputs through the measurement chains, then samples them.
MatrixXd record(const MatrixXd& fine, const std::vector<MeasurementChain>& chains, double fine_rate, Index substeps) {
  MatrixXd filtered = fine;
  for (std::size_t i = 0; i < chains.size(); ++i)
    filtered.col(static_cast<Index>(i)) = chains[i].filter(fine.col(static_cast<Index>(i)), fine_rate);
  return every(filtered, substeps);
}

double largest_change(const MatrixXd& finer, const MatrixXd& coarser) {
  double change = 0.0;
  for (Index j = 0; j < finer.cols(); ++j) change = std::max(change, nrmse(coarser.col(j), finer.col(j)));
  return change;
}

void check(const ReferenceOptions& options) {
  IssueList issues;
  if (!(options.sample_rate > 0.0) || !std::isfinite(options.sample_rate))
    issues.add({}, "the sampling rate is " + std::to_string(options.sample_rate) + " Hz", "it must be positive");
  if (options.first_substeps < 1 || options.max_substeps < options.first_substeps)
    issues.add({},
               "the time steps per sample go from " + std::to_string(options.first_substeps) + " to " +
                   std::to_string(options.max_substeps),
               "the first is at least 1, the last no less");
  if (!(options.tolerance > 0.0))
    issues.add({}, "the tolerance of the reference is " + std::to_string(options.tolerance), "it must be positive");
  issues.raise();
}

}  // namespace

Reference simulate_reference(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                             const InitialState& initial, const OutputMap& sensors,
                             const std::vector<MeasurementChain>& chains, SimulationOptions simulation,
                             const ReferenceOptions& options) {
  check(options);
  Reference reference;
  simulation.every_step = sensors;
  for (Index substeps = options.first_substeps; substeps <= options.max_substeps; substeps *= 2) {
    simulation.step = 1.0 / (options.sample_rate * static_cast<double>(substeps));
    simulation.keep_every = substeps;
    auto finer = simulate(system, signals, initial, simulation);
    if (finer.failure && substeps * 2 <= options.max_substeps) continue;  // a smaller step may converge
    const bool failed = finer.failure.has_value();
    MatrixXd finer_sensors =  // what was reached before a failure may be too large for the chains
        failed ? MatrixXd() : record(finer.every_step, chains, 1.0 / simulation.step, substeps);
    finer.every_step.resize(0, 0);
    const bool comparable = reference.substeps > 0 && !failed;
    reference.last_change = comparable ? largest_change(finer_sensors, reference.sensors) : 1.0;
    reference.simulation = std::move(finer);
    reference.sensors = std::move(finer_sensors);
    reference.substeps = substeps;
    reference.converged = comparable && reference.last_change <= options.tolerance;
    if (failed || reference.converged || sensors.size() == 0) break;
  }
  return reference;
}

}  // namespace kalfem
