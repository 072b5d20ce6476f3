// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/identification/record_estimation.hpp"
#include "kalfem/identification/unknown_inputs.hpp"

// What the parts of a sample interval leave in the motion: where the unknowns are known well, the deviations of forces
// and motions fall below what a step that settles the unknowns still leaves in them, at the kinks of laws above all.

namespace kalfem {

using Eigen::MatrixXd;

namespace {

constexpr int times_finer = 4;
constexpr double cost_of_mean = 0.2;  ///< filter steps that a step of the mean alone costs, about

}  // namespace

/// Of the run with so many substeps, by its gains, with the mean alone.
std::optional<MatrixXd> RecordEstimation::monitored_with(int substeps) const {
  const FilterRun run = run_with(substeps);
  const auto& setup = screening_->setup();
  const auto model = augmented_model_like(run, problem_, setup, screening_->record(), StateCoordinates::physical);
  const OutputMap monitored = with_inputs(make_outputs(*setup.model, options_.monitored),
                                          held_by(problem_->settings.unknown_inputs, setup), *setup.model);
  auto means = run_with_gains(*model, run.input, estimate_.result.gains, monitored, 0);
  if (!means) return std::nullopt;
  return std::move(means->monitored);
}

void RecordEstimation::widen_by_step(StepBudget& budget) {
  const int substeps = estimate_.substeps.substeps;
  const bool judged = estimate_.substeps.chosen && !estimate_.result.failure;
  if (!judged || std::ssize(estimate_.result.gains) != screening_->record().samples()) return;
  const double steps = steps_of_run(*problem_, screening_->record(), substeps);
  if (!budget.take(cost_of_mean * (1 + times_finer) * steps))
    return estimate_.leave_out("what a finer step would change in motions and forces");
  const auto as_it_is = monitored_with(substeps), finer = monitored_with(times_finer * substeps);
  if (as_it_is && finer) widen_monitored(*finer - *as_it_is);
  estimate_.result.gains = {};
}

}  // namespace kalfem
