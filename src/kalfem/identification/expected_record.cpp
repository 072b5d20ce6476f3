// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/expected_record.hpp"

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/named_unknowns.hpp"
#include "kalfem/identification/open_loop.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The record with the sensors' channels from the simulation, new ones behind the others.
Record with_channels(Record record, const std::vector<Sensor>& sensors, const MatrixXd& simulated) {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    Index row = record.find(sensors[i].name);
    if (row < 0) {
      row = record.values.rows();
      record.values.conservativeResize(row + 1, Eigen::NoChange);
      record.channels.push_back({sensors[i].name});
    }
    record.values.row(row) = simulated.row(static_cast<Index>(i));
    record.channels[static_cast<std::size_t>(row)].unit = sensors[i].unit;
  }
  return record;
}

/// The whole structure, whatever part of it the filter models.
EstimationProblemPtr whole(const EstimationProblemPtr& problem) {
  auto own = std::make_shared<EstimationProblem>(*problem);
  own->settings.local.reset();
  return own;
}

}  // namespace

void check_excitation_is_known(const EstimationProblem& problem, IssueList& issues) {
  const auto refuse = [&](const std::string& name, const SourceLocation& location) {
    issues.add(location, "the excitation '" + name + "' is unknown", "a record can be expected only under a known one",
               "state the excitation that is expected");
  };
  for (const auto& input : problem.settings.unknown_inputs) refuse(input.name, input.location);
  const auto& [parts, finite_elements, signals] = *problem.structure;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!signals[i]) refuse(parts.inputs[i].name, parts.inputs[i].location);
}

std::optional<Record> expected_record(const EstimationProblemPtr& problem, const Record& drive,
                                      const std::vector<std::string>& names, const VectorXd& theta) {
  IssueList issues;
  check_excitation_is_known(*problem, issues);
  if (theta.size() != std::ssize(names))
    issues.add({}, std::to_string(theta.size()) + " values for " + std::to_string(names.size()) + " unknowns",
               "every unknown needs its value", "give one value each");
  issues.raise();
  const NamedUnknowns unknowns(whole(problem), names);
  if (!unknowns.admissible(theta)) return std::nullopt;
  AugmentedModelSetup setup;
  try {
    const auto at = unknowns.problem_at(theta);
    setup = make_augmented_model_setup(*at, at->structure->parts, {}, issues);
    issues.raise();
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  const auto solution =
      simulate_open_loop({setup.model->system(), *setup.model, setup.sensors, problem->structure->signals},
                         setup.options.prior.mean, drive);
  if (solution.simulation.failure || !solution.sensors.allFinite()) return std::nullopt;
  Record record = with_channels(drive, setup.sensors, solution.sensors);
  for (const auto& sensor : setup.sensors) {
    const Index row = record.find(sensor.name);
    record.channels[static_cast<std::size_t>(row)].noise = sensor.deviation(rms(record.values.row(row).transpose()));
  }
  return unknowns.as_recorded(theta, std::move(record));
}

}  // namespace kalfem
