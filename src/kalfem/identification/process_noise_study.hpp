// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/step_budget.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct RecordEstimate;

/// What a record says of the unknowns with a process noise.
struct ProcessNoiseTrial {
  double factor = 1.0;          ///< on every density of acceleration noise of the settings
  double log_likelihood = 0.0;  ///< of the record
  double mean_nis = 0.0;
  /// Of the unknowns after the last sample [their units]; of one that walks, the means after settling.
  Eigen::VectorXd estimates, deviations;
};

struct ProcessNoiseStudy {
  std::vector<ProcessNoiseTrial> trials = {};
  bool stopped = false;  ///< the budget did not allow those that a verdict needs
};

/// The estimate beside those with a third, three times, a tenth and ten times the process noise, all else as it was, in
/// ascending order; without those at which the filter stops, and those that the budget does not allow. A Kalman
/// filter's estimates are best with the true covariance of the process noise, which nobody knows of a real structure:
/// this tells what depends on it. Nothing without process noise or unknowns, where it adapts, and for an estimate that
/// failed. `setup`: with which `estimate` was made.
ProcessNoiseStudy study_process_noise(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                      const Record& record, const RecordEstimate& estimate, StepBudget& budget);

}  // namespace kalfem
