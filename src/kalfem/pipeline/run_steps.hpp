// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Runs an augmented model of the case over the simulated or measured record, in bases of finite elements that suit the
/// estimates: `setup` is replaced where they need others. `on_first_answer` gets the first answer, if it is given.
EstimationOutcome run_estimation(const Study& study, AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress,
                                 const std::function<void(EstimationOutcome)>& on_first_answer);

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

/// Collects the displacement of the pictured substructure while a simulation runs.
class FieldCollector {
public:
  explicit FieldCollector(const Study& study);

  /// Makes the simulation hand over its snapshots; does nothing if the case asks for no pictures.
  void attach(SimulationOptions& options);
  [[nodiscard]] std::optional<FieldSeries> take();

private:
  void add(double time, const Eigen::VectorXd& displacement);

  const Study& study_;
  const FiniteElementSubstructure* elements_ = nullptr;
  std::vector<Eigen::Index> dofs_;  ///< of the substructure in the system
  FieldSeries series_;
  std::vector<Eigen::VectorXd> frames_;
};

/// The same from the estimated states, recovered from the reduced coordinates.
std::optional<FieldSeries> estimated_fields(const Study& study, const EstimationOutcome& outcome);

}  // namespace kalfem
