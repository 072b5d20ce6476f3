// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/sensor_events.hpp"
#include "kalfem/identification/step_budget.hpp"

namespace kalfem {

struct Correction;
struct DiagnosisInput;

/// How a mistake is undone in a run that is to be explained.
using Undo = std::function<Correction(const DiagnosisInput&)>;

/// What a run is of before unknown gains, clocks and noise, the problem's likelihood unknowns, are found.
struct UncorrectedRun {
  EstimationProblemPtr problem;
  StructureParts parts;
  Record record;
  std::vector<SensorEvent> events;  ///< whose samples do not count
  std::vector<Undo> undone = {};    ///< one after another
};

/// A run of a filter that is to be explained: the problem, the parts that its model is made of, and the record.
struct DiagnosisInput {
  EstimationProblemPtr problem;
  StructureParts parts;
  Record record;
  EstimationOptions options = {};
  Eigen::VectorXd nis = {};               ///< of the run that is to be explained, up to where it stopped
  double steps = StepBudget::unlimited;   ///< filter steps that all trials together may take
  std::vector<std::string> updated = {};  ///< parameters that an updating found: they are not held fixed
  /// Numbers of finite elements that differ from those of the problem's structure; `parts` have them.
  std::vector<std::pair<Parameter, double>> of_elements = {};
  /// Connectors that were added for forces which the structure may lack: nothing about them can be a mistake.
  std::vector<std::string> added = {};
  /// Changes of the inputs and the noise that the filter receives, one after another.
  std::vector<std::function<void(FilterRun&)>> on_run = {};
  /// Where the problem and the record have likelihood unknowns at the values that the run found; otherwise null.
  std::shared_ptr<const UncorrectedRun> uncorrected = {};

  /// The filter's run over the record. Throws InvalidInput as make_filter_run() does.
  [[nodiscard]] FilterRun run() const;
};

/// What is to be explained with a mistake undone: it can be searched for another one.
struct Correction {
  DiagnosisInput input;
  /// log |d corrected / d recorded| over all samples, which makes likelihoods of corrected records comparable.
  double log_jacobian = 0.0;
};

/// The input with a mistake undone. Unknown gains, clocks and noise are found again beside that, as they were found
/// with the mistake in the record or in the model.
DiagnosisInput found_again(const DiagnosisInput& input, const Undo& undo);

/// The input about a changed structure, whose finite elements keep the numbers that were corrected before.
Correction about(DiagnosisInput input, StructureModel structure);

/// Forces beside the laws of a structure, each as a connector of its own, with what is unknown of them.
struct FurtherForces {
  std::vector<ConnectorDescription> connectors;
  std::vector<Unknown> unknowns;
};
Correction with_forces(const DiagnosisInput& input, const FurtherForces& forces);

}  // namespace kalfem
