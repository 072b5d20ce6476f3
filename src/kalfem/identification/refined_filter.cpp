// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/refined_filter.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What of a run the choice of substeps needs.
struct Estimates {
  int substeps = 0;
  MatrixXd mean;       ///< unknowns x samples, or the last sample alone
  VectorXd deviation;  ///< at the end
  double nis = 0.0;    ///< mean over its expected value
};

bool any_drifts(const AugmentedModelSetup& setup) {
  return std::ranges::any_of(setup.options.unknowns, [](const auto& unknown) { return unknown.random_walk > 0.0; });
}

double relative_nis(const EstimationResult& result) {
  const auto there = result.nis.array().isFinite();
  return there.select(result.nis.array(), 0.0).sum() / std::max(1.0, static_cast<double>(result.measured.sum()));
}

/// Whether the model contradicts the record, and more substeps change little of it: what they change of the estimates
/// then says nothing about the step. What the step adds to the NIS falls at least by four where substeps double.
bool contradicts_anyway(const Estimates& coarse, const Estimates& fine) {
  constexpr double contradiction = 0.3, most = 0.5;
  const double excess = fine.nis - 1.0, without_step = excess - (coarse.nis - fine.nis) / 3.0;
  return without_step > std::max(contradiction, most * excess);
}

Estimates estimates_of(const AugmentedModelSetup& setup, const EstimationResult& result, int substeps) {
  const auto& [mean, deviation] = result.unknowns;
  return {substeps, any_drifts(setup) ? mean : MatrixXd(mean.rightCols(1)), deviation.rightCols(1),
          relative_nis(result)};
}

/// |difference| of two runs per unknown, in standard deviations of the finer one.
VectorXd distance(const AugmentedModelSetup& setup, const Estimates& one, const Estimates& other) {
  VectorXd distance(one.mean.rows());
  for (Index i = 0; i < distance.size(); ++i) {
    const VectorXd difference = (one.mean.row(i) - other.mean.row(i)).transpose();
    const bool drifts = setup.options.unknowns[static_cast<std::size_t>(i)].random_walk > 0.0;
    const double size = drifts ? difference.norm() / std::sqrt(static_cast<double>(difference.size()))
                               : std::abs(difference[difference.size() - 1]);
    distance[i] = size / std::max(other.deviation[i], 1e-300);
  }
  return distance;
}

/// By what the bias falls from the coarser to the finer.
double gain_of(int finer, int coarser, const SubstepOptions& options) {
  return std::pow(static_cast<double>(finer) / coarser, options.order);
}

bool is_small(const VectorXd& bias, const SubstepOptions& options) { return bias.maxCoeff() <= options.largest_bias; }

bool leaves_much(const SubstepChoice& choice, const SubstepOptions& options) {
  return choice.bias.size() == 0 || !is_small(choice.bias, options);
}

SubstepChoice stays_with_first(std::string words, const SubstepOptions& options) {
  return {.substeps = options.first, .chosen = true, .words = std::move(words)};
}

SubstepChoice contradicted(const SubstepOptions& options) {
  return stays_with_first("as more change nothing of how the model contradicts the record", options);
}

/// The most substeps for which the inputs at all of them can be held.
int most_substeps(const AugmentedModelSetup& setup, const Record& record, const SubstepOptions& options) {
  const auto values = 3.0 * static_cast<double>(std::max<std::size_t>(1, setup.input_sources.size())) *
                      static_cast<double>(record.samples()) * setup.options.step_order / 2.0;
  return static_cast<int>(std::min<double>(options.most, options.most_input_values / values));
}

/// Doubled as often as the bias asks for; no further than the limit.
int enough(const SubstepChoice& choice, int most, const SubstepOptions& options) {
  int next = 2 * choice.substeps;
  while (choice.bias.maxCoeff() / gain_of(next, choice.substeps, options) > options.largest_bias && 2 * next <= most)
    next *= 2;
  return next;
}

FilteredRecord run_with(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                        const EstimationOptions& options, int substeps) {
  setup.options.substeps = substeps;
  return run_filter(problem, setup, record, options);
}

}  // namespace

bool can_judge_step(const EstimationSettings& settings) { return settings.step_order == 4 && settings.passes == 1; }

std::optional<SubstepChoice> judge_within_run(const AugmentedModelSetup& setup, const EstimationResult& run,
                                              const SubstepOptions& substeps) {
  const MatrixXd& shift = run.step_shift;
  if (shift.size() == 0 || run.failure || !shift.allFinite()) return std::nullopt;
  Estimates estimates = estimates_of(setup, run, substeps.first), shifted = estimates;
  shifted.mean += shift.rightCols(shifted.mean.cols());
  SubstepChoice choice{.substeps = substeps.first, .chosen = true};
  choice.bias = distance(setup, shifted, estimates);
  choice.words = "from what a step of order 2 would shift in the estimates";
  if (!is_small(choice.bias, substeps)) return std::nullopt;
  return choice;
}

SubstepChoice compare_with_half(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                const Record& record, const EstimationOptions& options, const EstimationResult& first,
                                const SubstepOptions& substeps) {
  SubstepChoice choice{.substeps = substeps.first, .chosen = true};
  if (setup.options.unknowns.empty()) {
    choice.words = "there is no unknown whose estimate they could bias";
    return choice;
  }
  choice.words = "from the change of the estimates with the substeps";
  choice.limited = true;
  if (substeps.first < 2) return choice;
  EstimationOptions estimates_only = options;
  estimates_only.monitored = {};
  estimates_only.keep_unknowns = estimates_only.keep_gains = false;
  estimates_only.state_means = estimates_only.state_deviations = false;
  estimates_only.step_shift = false;
  const auto half = run_with(problem, setup, record, estimates_only, substeps.first / 2);
  if (half.result.failure) return choice;
  const Estimates fine = estimates_of(setup, first, substeps.first),
                  coarse = estimates_of(setup, half.result, substeps.first / 2);
  if (contradicts_anyway(coarse, fine)) return contradicted(substeps);
  choice.bias = distance(setup, coarse, fine) / (gain_of(fine.substeps, coarse.substeps, substeps) - 1.0);
  choice.limited = leaves_much(choice, substeps);
  return choice;
}

SettledSubsteps settle_substeps(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                const Record& record, const RunWithSubsteps& run, const EstimationResult& first,
                                SubstepChoice compared, StepBudget& budget, const SubstepOptions& substeps) {
  SettledSubsteps settled{std::move(compared), {}};
  SubstepChoice& choice = settled.choice;
  if (!choice.limited) return settled;
  const int most = most_substeps(setup, record, substeps);
  Estimates coarse = estimates_of(setup, first, substeps.first);
  VectorXd left;  // of the bias, by the runs of this search
  for (int next = 2 * substeps.first; next <= most; next = enough(choice, most, substeps)) {
    if (!budget.take(steps_of_run(problem, record, next))) {
      choice.stopped = true;
      return settled;
    }
    FilteredRecord finer = run(next);
    if (finer.result.failure) {
      choice.words = "because the filter failed with " + std::to_string(next);
      choice.bias = left;
      choice.limited = false;
      return settled;
    }
    const Estimates fine = estimates_of(setup, finer.result, next);
    if (contradicts_anyway(coarse, fine)) return {contradicted(substeps), {}};
    const VectorXd change = distance(setup, coarse, fine) / (gain_of(next, coarse.substeps, substeps) - 1.0);
    const VectorXd of_coarse = change * gain_of(next, coarse.substeps, substeps);
    if (coarse.substeps == substeps.first && is_small(of_coarse, substeps)) {
      choice.bias = of_coarse;
      break;
    }
    if (left.size() > 0 && change.maxCoeff() >= left.maxCoeff())
      return {stays_with_first("as more do not settle the estimates: these depend on the way from their priors more "
                               "than on the step",
                               substeps),
              {}};
    choice.bias = left = change;
    choice.substeps = next;
    settled.run = std::move(finer);
    if (is_small(change, substeps)) break;
    coarse = fine;
  }
  choice.limited = leaves_much(choice, substeps);
  return settled;
}

namespace {

RefinedFilter run_refined_from(const SubstepOptions& substeps, const EstimationProblemPtr& problem,
                               AugmentedModelSetup setup, const Record& record, const EstimationOptions& options) {
  const RunWithSubsteps run = [&](int count) { return run_with(problem, setup, record, options, count); };
  if (const auto given = problem->settings.substeps) return {run(*given), {.substeps = *given, .words = "given"}};
  if (setup.substeps) return {run(setup.substeps->substeps), *setup.substeps};
  EstimationOptions judged = options;
  judged.step_shift = can_judge_step(problem->settings);
  FilteredRecord first = run_with(problem, setup, record, judged, substeps.first);
  if (first.result.failure) {
    SubstepOptions from_there = substeps;
    from_there.first *= substeps.rescue;
    FilteredRecord finer = run(from_there.first);
    if (finer.result.failure) return {std::move(first), {.substeps = substeps.first, .chosen = true}};
    return run_refined_from(from_there, problem, std::move(setup), record, options);
  }
  setup.starts_at_rest = !first.run.start.moving;
  if (auto within = judge_within_run(setup, first.result, substeps)) return {std::move(first), *std::move(within)};
  StepBudget unlimited;
  auto settled =
      settle_substeps(*problem, setup, record, run, first.result,
                      compare_with_half(problem, setup, record, options, first.result, substeps), unlimited, substeps);
  return {settled.run ? std::move(*settled.run) : std::move(first), std::move(settled.choice)};
}

}  // namespace

RefinedFilter run_refined_filter(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                                 const EstimationOptions& options) {
  return run_refined_from(SubstepOptions::of(problem->settings.step_order), problem, std::move(setup), record, options);
}

}  // namespace kalfem
