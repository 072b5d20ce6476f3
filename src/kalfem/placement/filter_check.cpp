// SPDX-License-Identifier: Apache-2.0
#include "kalfem/placement/filter_check.hpp"

#include <algorithm>

#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Substeps bias estimates, and these are known here: their deviations hardly depend on the step.
constexpr int enough_for_deviations = 8;

EstimationProblemPtr problem_with(const PlacementProblem& placement, const std::vector<std::size_t>& set) {
  std::vector<CandidateSensor> sensors;
  for (const auto i : set) sensors.push_back(placement.candidates[i]);
  EstimationProblem problem = *with_sensors(*placement.problem, sensors);
  auto& settings = problem.settings;
  settings.local.reset();
  settings.likelihood_unknowns.clear();
  settings.adaptive_noise = {};
  settings.outliers = OutlierTreatment::keep;
  settings.diagnose = settings.smooth = false;
  settings.threads = 1;
  if (!settings.substeps) settings.substeps = enough_for_deviations;
  return std::make_shared<const EstimationProblem>(std::move(problem));
}

}  // namespace

VectorXd deviation_by_filter(const PlacementProblem& placement, const std::vector<std::size_t>& set) try {
  const auto problem = problem_with(placement, set);
  const auto record = expected_record(problem, placement.drive, {}, VectorXd());
  if (!record) return {};
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  const auto estimate = estimate_record(problem, setup, *record);
  if (estimate.result.failure) return {};
  VectorXd deviation(static_cast<Index>(placement.counted));
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < placement.counted; ++i) {
    const auto found = std::ranges::find(unknowns, placement.unknowns[i], &UnknownParameter::name);
    deviation[static_cast<Index>(i)] =
        estimate.result.unknowns.deviation(found - unknowns.begin(), estimate.result.unknowns.deviation.cols() - 1);
  }
  return deviation;
} catch (const InvalidInput&) {
  return {};
}

}  // namespace kalfem
