// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "kalfem/identification/filter_run.hpp"

namespace kalfem {

/// When a filter's model divides a sample interval finely enough.
struct SubstepOptions {
  /// For a filter's step of this order, AugmentedModelOptions::step_order: first runs of the same cost. A step of order
  /// 4 counts as one of order 3, between what laws with kinks and smooth ones give.
  static SubstepOptions of(int step_order) {
    return {.order = step_order == 4 ? 3 : 2, .first = step_order == 4 ? 2 : 4};
  }

  int order = 2;              ///< the bias falls with this power of the substeps
  double largest_bias = 0.2;  ///< of an unknown's estimate, in its standard deviations
  int first = 4;              ///< substeps of the first run
  int most = 128;
  int rescue = 4;  ///< a filter that fails with the first substeps is tried once with so many times more
  double most_input_values = 1e8;  ///< numbers of the inputs at all substeps of the record
};

/// Whether a run can be asked for EstimationOptions::step_shift.
bool can_judge_step(const EstimationSettings& settings);

/// What the embedded step of order 2 would shift in the estimates of a run with a step of order 4
/// (EstimationResult::step_shift), as their bias, where that is small already: the step itself errs by less. Nothing
/// otherwise; then only a comparison tells.
std::optional<SubstepChoice> judge_within_run(const AugmentedModelSetup& setup, const EstimationResult& run,
                                              const SubstepOptions& substeps);

/// The first comparison: what the substeps `options.first`, with which `first` was run, leave in the estimates, from
/// one run more with half of them (Richardson),
///     bias(N) = |theta(N) - theta(N')| / ((N / N')^p - 1),   N > N',
/// in stated standard deviations: the robust ones would grow with the very errors that a coarse step makes. Where the
/// connectors' laws are smooth the bias falls with the power p of the number N (SubstepOptions::order). The whole
/// record is used, because its hardest part, loud or fast, is seldom its start. An unknown with a random walk counts by
/// the root mean square over the record. `limited` where the bias is not small, or not known because the filter fails.
SubstepChoice compare_with_half(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                const Record& record, const EstimationOptions& options, const EstimationResult& first,
                                const SubstepOptions& substeps = {});

/// The filter's run over the record with so many substeps.
using RunWithSubsteps = std::function<FilteredRecord(int substeps)>;

/// A choice of substeps, and the filter's run with them; none where these are the first ones.
struct SettledSubsteps {
  SubstepChoice choice;
  std::optional<FilteredRecord> run;
};

/// The number of substeps at which the bias of every unknown's estimate is small: `compared` where it is already, else
/// as many more as the bias asks for, until it is. Where the filter fails with more substeps, it stays with those of
/// the last run that did not. Ends, `limited`, before a run that the budget does not allow.
SettledSubsteps settle_substeps(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                const Record& record, const RunWithSubsteps& run, const EstimationResult& first,
                                SubstepChoice compared, StepBudget& budget, const SubstepOptions& substeps = {});

/// A run of the filter, and the substeps it was made with.
struct RefinedFilter {
  FilteredRecord filtered;
  SubstepChoice substeps;
};

/// run_filter() with the substeps of the settings, with those decided before (AugmentedModelSetup::substeps), or with
/// as many as the estimates need: the first run tells where two are enough, otherwise a run with half of them. A number
/// that is given is not checked, as that would cost the run that it saves.
RefinedFilter run_refined_filter(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                                 const EstimationOptions& options);

}  // namespace kalfem
