#pragma once

#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Runs an augmented model of the case over the simulated or measured record. `failure` says in words why the numbers
/// are not usable.
EstimationOutcome run_estimation(const Study& study, const AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress, std::string& failure);

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

/// Estimates that contradict their priors, a sentence each.
struct PriorConflicts {
  std::vector<std::string> warnings;  ///< the estimate may hold all the same
  std::vector<std::string> failures;  ///< it cannot be trusted
};

/// The unknowns whose estimates ended more than four prior standard deviations from their first guesses. The filter
/// linearises about its estimate, so that an estimate that travels so far may be wrong by many of its stated
/// deviations: it cannot be trusted where the mean NIS is more than a fifth above the expected one as well. Unknowns
/// that are allowed to drift are left out.
PriorConflicts prior_conflicts(const EstimationOutcome& outcome);

/// Collects the displacement of the substructure that the case wants pictures of, while a simulation runs.
class FieldCollector {
public:
  explicit FieldCollector(const Study& study);

  /// Lets the simulation hand its snapshots over; nothing where the case asks for no pictures.
  void attach(SimulationOptions& options);
  [[nodiscard]] std::optional<FieldSeries> take();

private:
  void add(double time, const Eigen::VectorXd& displacement);

  const Study& study_;
  const FiniteElementSubstructure* elements_ = nullptr;
  Eigen::Index offset_ = 0;
  FieldSeries series_;
  std::vector<Eigen::VectorXd> frames_;
};

/// The same from the estimated states, recovered from the reduced coordinates.
std::optional<FieldSeries> estimated_fields(const Study& study, const EstimationOutcome& outcome);

}  // namespace kalfem
