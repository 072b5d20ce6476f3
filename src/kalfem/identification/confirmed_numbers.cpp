// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fixed_number_study.hpp"

#include <algorithm>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/runs_beside.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_confirmed = 3;
constexpr double most_change = 0.5;  ///< in a number's scale, of a run with it

/// Runs of the estimate itself with other changes of the numbers.
class RunsOfEstimate {
public:
  RunsOfEstimate(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                 const RecordEstimate& estimate, const FixedNumberStudy& study)
      : problem_(problem), setup_(setup), record_(record), estimate_(estimate), study_(study) {
    setup_.starts_at_rest = !estimate.start.moving;
    setup_.options.substeps = estimate.augmented_model->options().substeps;
  }

  /// By which they raise ln L; minus infinity where they make no structure, or the filter stops.
  [[nodiscard]] double rise(const VectorXd& changes) const try {
    const auto at = at_numbers(problem_, setup_, record_, from_here({study_.numbers, changes}));
    const FilterRun run = make_filter_run(at.problem, at.setup, at.record);
    EstimationOptions options = rerun_options(run.choice.filter, problem_->settings, estimate_);
    options.passes = problem_->settings.passes;
    const EstimationResult result = kalfem::estimate(*run.choice.augmented_model, run.input, options);
    if (result.failure) return -std::numeric_limits<double>::infinity();
    return log_likelihood_from(result, estimate_.settled) - log_likelihood_from(estimate_.result, estimate_.settled) +
           at.log_jacobian.tail(std::max<Index>(0, at.log_jacobian.size() - estimate_.settled)).sum();
  } catch (const InvalidInput&) {
    return -std::numeric_limits<double>::infinity();
  }

private:
  /// The structure is at all of them, signals from where they stand.
  [[nodiscard]] ChangedNumbers from_here(ChangedNumbers changed) const {
    for (Index n = 0; n < study_.size(); ++n)
      if (!study_.numbers[static_cast<std::size_t>(n)].parameter) changed.changes[n] -= study_.stands_at[n];
    return changed;
  }

  const EstimationProblemPtr& problem_;
  AugmentedModelSetup setup_;
  const Record& record_;
  const RecordEstimate& estimate_;
  const FixedNumberStudy& study_;
};

}  // namespace

void confirm_asked(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                   const RecordEstimate& estimate, FixedNumberStudy& study) {
  std::vector<Index> likely;
  for (Index i = 0; i < study.size(); ++i)
    if (study.is_significant(i)) likely.push_back(i);
  std::ranges::stable_sort(likely, std::ranges::greater{}, [&](Index i) { return study.gain[i]; });
  if (likely.size() > most_confirmed) likely.resize(most_confirmed);
  const RunsOfEstimate runs(problem, setup, record, estimate, study);
  for_each_index(likely.size(), processors(), [&](std::size_t n) {
    const Index i = likely[n];
    const VectorXd changes = study.with_asked(i, most_change);
    study.confirmed[i] = runs.rise(changes) - pull(study.numbers, changes, i) + pull(study.numbers, study.stands_at, i);
  });
}

}  // namespace kalfem
