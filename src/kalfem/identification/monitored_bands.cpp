// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/identification/record_estimation.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/unknown_inputs.hpp"

// What the bands of motions and forces hold beside the filter's deviations.

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int times_finer = 4;
constexpr int passes_of_smoother = 2;
constexpr double cost_of_mean = 0.2;  ///< filter steps that a step of the mean alone costs, about

void widen(const MatrixXd& added, EstimatedSeries& series) {
  series.deviation = (series.deviation.cwiseAbs2() + added.cwiseAbs2()).cwiseSqrt();
}

/// Monitored quantities, and the unknown inputs behind them.
void widen(const MatrixXd& added, EstimatedSeries& monitored, std::vector<EstimatedInput>& inputs) {
  const Index quantities = monitored.deviation.rows();
  widen(added.topRows(quantities), monitored);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const VectorXd of_input = added.row(quantities + static_cast<Index>(i)).transpose();
    inputs[i].deviation = (inputs[i].deviation.cwiseAbs2() + of_input.cwiseAbs2()).cwiseSqrt();
  }
}

}  // namespace

void RecordEstimation::widen_monitored(const MatrixXd& filtered, const MatrixXd& smoothed) {
  widen(filtered, estimate_.result.monitored, estimate_.inputs);
  if (estimate_.smoothed) widen(smoothed, estimate_.smoothed->monitored, estimate_.smoothed_inputs);
}

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

/// Where the unknowns are known well, the deviations of forces and motions fall below what a step that settles the
/// unknowns still leaves in them, at the kinks of laws above all.
void RecordEstimation::widen_by_step(StepBudget& budget) {
  const int substeps = estimate_.substeps.substeps;
  const bool judged = estimate_.substeps.chosen && !estimate_.result.failure;
  if (!judged || std::ssize(estimate_.result.gains) != screening_->record().samples()) return;
  const double steps = steps_of_run(*problem_, screening_->record(), substeps);
  if (!budget.take(cost_of_mean * (1 + times_finer) * steps))
    return estimate_.leave_out("what a finer step would change in motions and forces");
  const auto as_it_is = monitored_with(substeps), finer = monitored_with(times_finer * substeps);
  if (as_it_is && finer) widen_monitored(*finer - *as_it_is, *finer - *as_it_is);
  estimate_.result.gains = {};
}

/// The run once more, with what the scores along the record say of the unknowns beyond its deviations.
void RecordEstimation::widen_by_scores(StepBudget& budget) {
  EstimationOptions options = screening_->options();
  options.excess = excess_of(estimate_);
  if (options.excess.size() == 0 || options.monitored.size() == 0) return;
  constexpr auto left_out = "what contradictions along the record add to motions and forces";
  // Of a run that contradicts itself the mistake is looked for first.
  if (budget.is_limited() && innovations_contradict(estimate_, estimate_.settled)) return estimate_.leave_out(left_out);
  const int passes = options.passes + (estimate_.smoothed ? passes_of_smoother : 0);
  if (!budget.take(passes * steps_of_run(*problem_, screening_->record(), estimate_.substeps.substeps)))
    return estimate_.leave_out(left_out);
  options.filter = run_->choice.filter;
  options.step_shift = options.keep_gains = false;
  const auto& model = *run_->choice.augmented_model;
  const EstimationResult again = kalfem::estimate(model, run_->input, options);
  if (again.failure) return;
  std::optional<SmoothedRecord> smoothed;
  if (estimate_.smoothed) smoothed = smooth(model, run_->input, options, again);
  if (!estimate_.smoothed || smoothed)
    widen_monitored(again.monitored_excess, smoothed ? smoothed->monitored_excess : MatrixXd());
}

}  // namespace kalfem
