#pragma once

#include "kalfem/identification/filter_run.hpp"

namespace kalfem {

/// When a filter's model divides a sample interval finely enough.
struct SubstepOptions {
  double largest_bias = 0.2;  ///< of an unknown's estimate, in its standard deviations
  int first = 4;              ///< substeps of the first run
  int most = 128;
  double most_input_values = 1e8;  ///< numbers of the inputs at all substeps of the record
};

/// The number of substeps at which the bias of every unknown's estimate is small. Connector forces and inputs are
/// linear over a substep, so the bias falls with the square of their number N. Two runs over the record tell it
/// (Richardson),
///     bias(N) = |theta(N) - theta(N')| / ((N / N')^2 - 1),   N > N',
/// in stated standard deviations: the robust ones would grow with the very errors that a coarse step makes. The whole
/// record is used, because its hardest part, loud or fast, is seldom its start. `first`: result of a run with
/// `substeps.first`. An unknown with a random walk counts by the root mean square over the record.
///
/// The first N is compared with half of it, which costs a quarter of a comparison with its double. Only where that does
/// not show a small bias are more substeps tried.
///
/// Where the filter fails with more substeps, it stays with those of the last run that did not.
SubstepChoice choose_substeps(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                              const Record& record, const EstimationOptions& options, const EstimationResult& first,
                              const SubstepOptions& substeps = {});

/// A run of the filter, and the substeps it was made with.
struct RefinedFilter {
  FilteredRecord filtered;
  SubstepChoice substeps;
};

/// run_filter() with the substeps of the settings, with those decided before (AugmentedModelSetup::substeps), or with
/// as many as the estimates need: one run more over the record, with 2, where 4 are enough. A number that is given is
/// not checked, as that would cost the run that it saves.
RefinedFilter run_refined_filter(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                                 const EstimationOptions& options, const SubstepOptions& substeps = {});

}  // namespace kalfem
