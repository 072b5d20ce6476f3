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

double square_of_ratio(int finer, int coarser) {
  const double ratio = static_cast<double>(finer) / coarser;
  return ratio * ratio;
}

/// Runs the filter with fewer and more substeps, to see what these change of the estimates.
class SubstepSearch {
public:
  SubstepSearch(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                const EstimationOptions& options, const SubstepOptions& substeps)
      : problem_(problem), setup_(setup), record_(record), options_(options), substeps_(substeps) {
    options_.monitored = {};
    options_.keep_unknowns = options_.keep_gains = options_.state_means = options_.state_deviations = false;
  }

  SubstepChoice compared_with_half(const EstimationResult& first) {
    SubstepChoice choice{.substeps = substeps_.first, .chosen = true};
    if (setup_.options.unknowns.empty()) {
      choice.words = "there is no unknown whose estimate they could bias";
      return choice;
    }
    choice.words = "from the change of the estimates with the substeps";
    const Estimates fine = estimates_of(setup_, first, substeps_.first);
    if (const auto coarse = run_with_half_of(fine)) {
      if (contradicts_anyway(*coarse, fine)) return contradicted();
      choice.bias = distance(setup_, *coarse, fine) / (square_of_ratio(fine.substeps, coarse->substeps) - 1.0);
    }
    choice.limited = choice.bias.size() == 0 || !is_small(choice.bias);
    return choice;
  }

  SubstepChoice from(const EstimationResult& first, SubstepChoice choice, StepBudget& budget) {
    if (!choice.limited) return choice;
    Estimates coarse = estimates_of(setup_, first, substeps_.first);
    VectorXd left;  // of the bias, by the runs of this search
    for (int next = 2 * substeps_.first;; next = enough(choice)) {
      if (next > most()) break;
      const double steps = steps_of_run(*problem_, record_, next);
      if (!budget.allows(2.0 * steps)) {  // this run and, should it be the last, that of the estimate
        choice.stopped = true;
        return choice;
      }
      budget.take(steps);
      const auto fine = run_with(next);
      if (!fine) {
        choice.words = "because the filter failed with " + std::to_string(next);
        choice.bias = left;
        choice.limited = false;
        return choice;
      }
      if (contradicts_anyway(coarse, *fine)) return contradicted();
      const VectorXd change = distance(setup_, coarse, *fine) / (square_of_ratio(next, coarse.substeps) - 1.0);
      const VectorXd of_coarse = change * square_of_ratio(next, coarse.substeps);
      if (coarse.substeps == substeps_.first && is_small(of_coarse)) {
        choice.bias = of_coarse;
        break;
      }
      if (left.size() > 0 && change.maxCoeff() >= left.maxCoeff())
        return stays_with_first(
            "as more do not settle the estimates: these depend on the way from their priors more than on the step");
      choice.bias = left = change;
      choice.substeps = next;
      if (is_small(change)) break;
      coarse = *fine;
    }
    choice.limited = choice.bias.size() == 0 || !is_small(choice.bias);
    return choice;
  }

private:
  [[nodiscard]] bool is_small(const VectorXd& bias) const { return bias.maxCoeff() <= substeps_.largest_bias; }

  [[nodiscard]] SubstepChoice stays_with_first(std::string words) const {
    return {.substeps = substeps_.first, .chosen = true, .words = std::move(words)};
  }

  [[nodiscard]] SubstepChoice contradicted() const {
    return stays_with_first("as more change nothing of how the model contradicts the record");
  }

  /// Nothing where the filter fails with half of the substeps, or ran with one.
  [[nodiscard]] std::optional<Estimates> run_with_half_of(const Estimates& fine) const {
    return fine.substeps < 2 ? std::nullopt : run_with(fine.substeps / 2);
  }

  /// The most substeps for which the inputs at all of them can be held.
  [[nodiscard]] int most() const {
    const auto values = 3.0 * static_cast<double>(std::max<std::size_t>(1, setup_.input_sources.size())) *
                        static_cast<double>(record_.samples());
    return static_cast<int>(std::min<double>(substeps_.most, substeps_.most_input_values / values));
  }

  /// Doubled as often as the bias asks for, which falls with the square; no further than the limit.
  [[nodiscard]] int enough(const SubstepChoice& choice) const {
    int next = 2 * choice.substeps;
    while (choice.bias.maxCoeff() / square_of_ratio(next, choice.substeps) > substeps_.largest_bias &&
           2 * next <= most())
      next *= 2;
    return next;
  }

  [[nodiscard]] std::optional<Estimates> run_with(int substeps) const {
    AugmentedModelSetup setup = setup_;
    setup.options.substeps = substeps;
    const auto filtered = run_filter(problem_, setup, record_, options_);
    if (filtered.result.failure) return std::nullopt;
    return estimates_of(setup_, filtered.result, substeps);
  }

  const EstimationProblemPtr& problem_;
  const AugmentedModelSetup& setup_;
  const Record& record_;
  EstimationOptions options_;
  SubstepOptions substeps_;
};

RefinedFilter run_with(const EstimationProblemPtr& problem, AugmentedModelSetup& setup, const Record& record,
                       const EstimationOptions& options, SubstepChoice choice) {
  setup.options.substeps = choice.substeps;
  return {run_filter(problem, setup, record, options), std::move(choice)};
}

}  // namespace

SubstepChoice compare_with_half(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                const Record& record, const EstimationOptions& options, const EstimationResult& first,
                                const SubstepOptions& substeps) {
  return SubstepSearch(problem, setup, record, options, substeps).compared_with_half(first);
}

SubstepChoice choose_substeps(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                              const Record& record, const EstimationOptions& options, const EstimationResult& first,
                              SubstepChoice compared, StepBudget& budget, const SubstepOptions& substeps) {
  SubstepChoice choice =
      SubstepSearch(problem, setup, record, options, substeps).from(first, std::move(compared), budget);
  if (choice.substeps != substeps.first) budget.take(steps_of_run(*problem, record, choice.substeps));
  return choice;
}

SubstepChoice kept_at_first(SubstepChoice choice, int first) {
  choice.words = "because the filter failed with " + std::to_string(choice.substeps);
  choice.bias *= square_of_ratio(choice.substeps, first);
  choice.substeps = first;
  choice.limited = true;
  return choice;
}

RefinedFilter run_refined_filter(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                                 const EstimationOptions& options, const SubstepOptions& substeps) {
  if (const auto given = problem->settings.substeps)
    return run_with(problem, setup, record, options, {.substeps = *given, .words = "given"});
  if (setup.substeps) return run_with(problem, setup, record, options, *setup.substeps);
  auto first = run_with(problem, setup, record, options, {.substeps = substeps.first, .chosen = true});
  if (first.filtered.result.failure) {
    auto finer =
        run_with(problem, setup, record, options, {.substeps = substeps.rescue * substeps.first, .chosen = true});
    if (finer.filtered.result.failure) return first;
    SubstepOptions from_there = substeps;
    from_there.first = substeps.rescue * substeps.first;
    return run_refined_filter(problem, std::move(setup), record, options, from_there);
  }
  setup.starts_at_rest = !first.filtered.run.start.moving;
  const auto& result = first.filtered.result;
  StepBudget unlimited;
  auto choice =
      choose_substeps(problem, setup, record, options, result,
                      compare_with_half(problem, setup, record, options, result, substeps), unlimited, substeps);
  if (choice.substeps == first.substeps.substeps) return {std::move(first.filtered), std::move(choice)};
  auto last = run_with(problem, setup, record, options, choice);
  if (!last.filtered.result.failure) return last;
  return {std::move(first.filtered), kept_at_first(std::move(choice), first.substeps.substeps)};
}

}  // namespace kalfem
