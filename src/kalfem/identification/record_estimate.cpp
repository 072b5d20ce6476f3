// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/record_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/asked_numbers.hpp"
#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/record_estimation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The finite elements are reduced again if the linear unknowns moved further than this, relative: the error of a fixed
/// basis is about its square. The second constant limits the repetitions.
constexpr double reduction_reach = 0.02;
constexpr int most_reductions = 3;
constexpr int most_freed = 3;

/// Largest relative distance of the linear unknowns from the values at which the finite elements were reduced. Only
/// unknowns on which the bases depend count.
double distance(const LinearUnknowns& unknowns, const VectorXd& values) {
  double largest = 0.0;
  for (const auto& [index, parameter] : unknowns.bindings) {
    const auto* target = std::get_if<FiniteElementParameter>(&parameter.where);
    if (!target || target->kind != FiniteElementParameter::Kind::matrix) continue;
    const double before = unknowns.reduced_at[index];
    if (before != 0.0) largest = std::max(largest, std::abs(values[index] / before - 1.0));
  }
  return largest;
}

/// Where linear unknowns ended far from the values at which the finite elements were reduced: reduces these there, with
/// the substeps of the estimate, and answers again, where the budget allows that. The filter steps that this took.
double renew_bases(const EstimationProblemPtr& problem, AugmentedModelSetup& setup, const Record& record,
                   const RecordEstimateOptions& options, StepBudget& budget, RecordEstimation& estimation) {
  RecordEstimate& estimate = estimation.estimate();
  double steps = 0.0;
  while (!setup.linear_unknowns.bindings.empty() && estimate.reductions < most_reductions && !estimate.result.failure) {
    const VectorXd values = linear_estimates(estimate);
    if (distance(setup.linear_unknowns, values) < reduction_reach) break;
    if (!budget.take(steps_of_run(*problem, record, estimate.substeps.substeps))) {
      estimate.leave_out("finite elements reduced at the estimates");
      break;
    }
    IssueList issues;
    setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues, values);
    issues.raise();
    setup.substeps = estimate.substeps;
    const auto [reductions, thoughts, left_out] =
        std::tuple(estimate.reductions + 1, estimate.second_thoughts, estimate.left_out);
    estimation = RecordEstimation(problem, setup, record, options);
    estimation.answer();
    estimate.reductions = reductions;
    estimate.second_thoughts = thoughts;
    estimate.left_out = left_out;
    steps += estimation.steps();
  }
  return steps;
}

/// What a filter's model of another problem answers to the record, with what the estimate before it was.
void answer_again(RecordEstimation other, const AugmentedModelSetup& setup, RecordEstimation& estimation) {
  RecordEstimate& estimate = estimation.estimate();
  const int reductions = setup.linear_unknowns.bindings.empty() ? 0 : 1;
  const auto [thoughts, left_out] = std::tuple(estimate.second_thoughts, estimate.left_out);
  estimation = std::move(other);
  estimation.answer();
  estimate.reductions = reductions;
  estimate.second_thoughts = thoughts;
  estimate.left_out = left_out;
}

/// The estimate of the problem with a number more among its unknowns, and what it owes to those that stay fixed.
/// Nothing changes where the budget does not allow it, or the filter stops with it.
bool take_with(const EstimationProblemPtr& with, AugmentedModelSetup& setup, const Record& record,
               const RecordEstimateOptions& options, StepBudget& budget, RecordEstimation& estimation) {
  const int substeps = estimation.estimate().substeps.substeps;
  if (!budget.take(steps_of_run(*with, record, substeps))) {
    estimation.estimate().leave_out("numbers that the record asks for, as unknowns");
    return false;
  }
  IssueList issues;
  auto other = make_augmented_model_setup(*with, *setup.parts, setup.linear_unknowns.present, issues);
  issues.raise();
  other.substeps = estimation.estimate().substeps;
  const RecordEstimation before = estimation;
  answer_again(RecordEstimation(with, other, record, options), other, estimation);
  if (estimation.estimate().result.failure) {
    estimation = before;
    return false;
  }
  setup = std::move(other);
  estimation.repeat_from_estimates(budget);
  estimation.settle_substeps(budget);
  renew_bases(with, setup, record, options, budget, estimation);
  estimation.confirm_by_second_pass(budget);
  estimation.widen_by_step(budget);
  estimation.study_fixed_numbers(budget);
  return true;
}

/// Whether there may be anything to ask for: where the likeliest number cannot be what is wrong, a mistake is looked
/// for.
bool is_worth_asking(const RecordEstimate& estimate) {
  const auto asked = asked_numbers(estimate);
  return !asked.empty() && may_be_all_that_is_wrong(estimate, asked.front());
}

/// Tries fixed numbers that the record asks to change as unknowns, and takes those kept where the settings say so, one
/// after another.
void free_numbers(const EstimationProblemPtr& problem, AugmentedModelSetup& setup, const Record& record,
                  const RecordEstimateOptions& options, StepBudget& budget, RecordEstimation& estimation) {
  RecordEstimate& estimate = estimation.estimate();
  FreedNumbers freed{.how = problem->settings.free};
  std::optional<RecordEstimate> before;
  for (int round = 0; estimate.fixed_numbers && options.updated.empty() && round < most_freed; ++round) {
    if (freed.how == FreeNumbers::none) break;
    if (freed.how == FreeNumbers::ask && !is_worth_asking(estimate)) break;
    NumberTrials trials = estimation.try_numbers(budget);
    if (trials.stopped) estimate.leave_out("numbers that the record asks for, as unknowns");
    freed.tried.insert(freed.tried.end(), trials.tried.begin(), trials.tried.end());
    if (trials.tried.empty() || !trials.tried.back().kept) break;
    const TriedNumber& kept = trials.tried.back();
    const auto with = with_unknown(freed.problem ? *freed.problem : *problem, kept.number, kept.prior);
    if (freed.how == FreeNumbers::ask) {
      freed.problem = with;
      freed.moved = trials.moved;
      break;
    }
    if (!before) before = estimate;
    if (!take_with(with, setup, record, options, budget, estimation)) {
      freed.tried.back().kept = false;
      break;
    }
    freed.problem = with;
    freed.taken = true;
    freed.moved = moved_estimates(*before, estimate);
  }
  estimate.freed = std::make_shared<const FreedNumbers>(std::move(freed));
}

/// Of the usual first answer: one that takes fewer leaves as many for what follows.
double usual_steps(const Record& record) {
  constexpr double a_sample = 6.0;
  return a_sample * static_cast<double>(record.samples());
}

}  // namespace

std::string RecordEstimate::failure() const {
  if (!result.failure) return "";
  return "the filter stopped at " + shortest(measurements.start + result.failure->time) +
         " s: " + result.failure->reason;
}

void RecordEstimate::leave_out(std::string what) {
  left_out.push_back(std::move(what));
  if (second_thoughts != SecondThoughts::none) second_thoughts = SecondThoughts::stopped;
}

std::string to_string(SecondThoughts thoughts) {
  switch (thoughts) {
    case SecondThoughts::none:
      return "none";
    case SecondThoughts::pending:
      return "pending";
    case SecondThoughts::done:
      return "done";
    case SecondThoughts::stopped:
      return "stopped";
  }
  return "";
}

EstimationOptions rerun_options(FilterKind filter, const EstimationSettings& settings, const RecordEstimate& estimate) {
  EstimationOptions options{.filter = filter,
                            .unscented = settings.unscented,
                            .threads = filter_threads(settings),
                            .state_means = false,
                            .state_deviations = false,
                            .adaptive_noise = settings.adaptive_noise,
                            .held_out = estimate.held_out};
  options.outliers.treatment = estimate.outliers;
  return options;
}

EstimationProblemPtr about_estimates(const EstimationProblem& problem, const RecordEstimate& estimate, double breadth) {
  auto about = std::make_shared<EstimationProblem>(problem);
  const Index last = estimate.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < about->settings.unknowns.size(); ++i) {
    auto& unknown = about->settings.unknowns[i];
    const double value = estimate.result.unknowns.mean(static_cast<Index>(i), last);
    const double before = unknown.transform.slope(unknown.transform.to_state(unknown.initial));
    const double slope = unknown.transform.slope(unknown.transform.to_state(value));
    if (unknown.random_walk > 0.0 || !(slope > 1e-6 * before)) continue;
    unknown.initial = value;
    const double own = estimate.result.unknowns.deviation(static_cast<Index>(i), last);
    unknown.deviation = std::min(unknown.deviation * slope / before, breadth * own);
  }
  about->settings.substeps = estimate.augmented_model->options().substeps;
  about->settings.passes = 1;
  return about;
}

VectorXd linear_estimates(const RecordEstimate& estimate) {
  return estimate.result.unknowns.mean.rightCols(1)(linear_unknowns(estimate.augmented_model->options()), 0);
}

RecordEstimate estimate_record(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                               const Record& record, const RecordEstimateOptions& options) {
  RecordEstimation estimation(problem, setup, record, options);
  StepBudget unlimited;
  estimation.answer();
  estimation.repeat_from_estimates(unlimited);
  estimation.settle_substeps(unlimited);
  estimation.confirm_by_second_pass(unlimited);
  estimation.look_for_jump(unlimited);
  return std::move(estimation.estimate());
}

RecordEstimate estimate_record_thoroughly(const EstimationProblemPtr& problem, AugmentedModelSetup& setup,
                                          const Record& record, const RecordEstimateOptions& options) {
  RecordEstimation estimation(problem, setup, record, options);
  RecordEstimate& estimate = estimation.estimate();
  estimation.answer();
  if (!setup.linear_unknowns.bindings.empty()) estimate.reductions = 1;
  StepBudget unlimited;
  const double steps = estimation.steps() + renew_bases(problem, setup, record, options, unlimited, estimation);
  const double allowed = problem->settings.second_thoughts;
  StepBudget budget(allowed > 0.0 ? allowed * std::max(steps, usual_steps(record)) : 0.0);
  estimate.second_thoughts = allowed > 0.0 ? SecondThoughts::pending : SecondThoughts::none;
  if (options.on_first_answer) options.on_first_answer(estimate);
  estimation.repeat_from_estimates(budget);
  if (budget.is_limited() && estimation.shows_a_change()) estimation.look_for_jump(budget);
  estimation.settle_substeps(budget);
  renew_bases(problem, setup, record, options, budget, estimation);
  estimation.confirm_by_second_pass(budget);
  const bool stated = !problem->settings.known_to.empty();
  const bool moved = stated && move_within_stated(estimation);
  estimation.look_for_jump(budget);
  if (stated && !moved && estimate.jump && move_within_stated(estimation)) estimation.look_for_jump(budget);
  estimation.widen_by_step(budget);
  estimation.study_fixed_numbers(budget);
  free_numbers(problem, setup, record, options, budget, estimation);
  estimation.study_process_noise(budget);
  estimation.confirm_information(budget);
  estimation.widen_by_scores(budget);
  estimation.hold_out_sensors(budget);
  if (estimate.second_thoughts == SecondThoughts::pending) estimate.second_thoughts = SecondThoughts::done;
  estimate.steps_left = budget.left();
  return std::move(estimate);
}

}  // namespace kalfem
