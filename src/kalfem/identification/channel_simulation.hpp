// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// theta's positions in the structure, by the names of unknowns. Adds an issue for each name that is no unknown of the
/// structure, such as a sensor's gain, or that comes twice.
std::vector<StructureBinding> bindings_of_unknowns(const EstimationProblem& problem,
                                                   const std::vector<std::string>& names, IssueList& issues);

/// Channels of a structure as functions of its parameters: it starts at rest and moves under its known excitation over
/// a record's time. Every simulation has the same step, so that outputs are smooth in the parameters. outputs() may be
/// called from several threads.
class ChannelSimulation {
public:
  /// `drive`: whose time is simulated. Finite elements keep the bases of their reduction at `theta`. Throws
  /// InvalidInput where theta makes no structure.
  ChannelSimulation(const EstimationProblem& problem, const Record& drive, std::vector<Sensor> channels,
                    std::vector<StructureBinding> bindings, const Eigen::VectorXd& theta);

  /// Decides the step. Root mean square of every channel; empty where the simulation fails.
  [[nodiscard]] std::optional<Eigen::VectorXd> start(const StructurePtr& given, const Eigen::VectorXd& theta);
  /// Channels x samples; empty where the simulation fails or the values are impossible.
  [[nodiscard]] std::optional<Eigen::MatrixXd> outputs(const Eigen::VectorXd& theta) const;

private:
  [[nodiscard]] StructureParts parts_at(const Eigen::VectorXd& theta) const;

  static constexpr Eigen::Index fewest_substeps = 4;  ///< of a sample interval

  std::vector<Sensor> channels_;
  std::vector<StructureBinding> bindings_;
  ParameterisedStructure structure_;
  StructureAtParameters here_;
  Record time_;  ///< without channels
  std::vector<SignalPtr> signals_;
  std::vector<OutputDescription> sampled_, stepped_;  ///< of channels without and with a measurement chain, in order
  Eigen::Index substeps_ = fewest_substeps;
};

}  // namespace kalfem
