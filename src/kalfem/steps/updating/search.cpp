// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/updating/checkpoint.hpp"
#include "kalfem/updating/global_search.hpp"
#include "kalfem/updating/modal_residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The weighted sum of all comparisons at one continuation step.
ResidualSum sum_of(const std::vector<ComparisonResidual>& comparisons, std::size_t step) {
  std::vector<ResidualSum::Term> terms;
  for (const auto& comparison : comparisons) terms.push_back({comparison.step(step), comparison.weight});
  return ResidualSum(std::move(terms));
}

std::size_t continuation_steps_of(const std::vector<ComparisonResidual>& comparisons) {
  std::size_t continuation_steps = 1;
  for (const auto& comparison : comparisons)
    continuation_steps = std::max(continuation_steps, comparison.continuation_steps.size());
  return continuation_steps;
}

/// Runs a search evaluation by evaluation, and writes down and shows each.
class TracedSearch {
public:
  TracedSearch(const Study& study, const RunOptions& options, UpdatingOutcome& updating)
      : study_(study), options_(options), outcome_(updating) {}

  /// From a point, or from the checkpoint of an earlier run, where one is kept. `first`: the residual at the start, if
  /// it is known; `last`: that at the end.
  GaussNewton run(const ResidualSum& residual, const VectorXd& start, const ResidualValue* first, LastResidual& last,
                  const UpdatingCheckpoint* checkpoint) {
    const auto options = study_.updating_plan->search;
    GaussNewtonState state = starting_at(start, options);
    if (auto earlier = checkpoint ? checkpoint->read() : std::nullopt) {
      state = std::move(earlier->state);
      outcome_.trace = std::move(earlier->trace);
      outcome_.resumed_at = state.evaluations;
    }
    GaussNewton search(study_.updating->parameters, options, state);
    while (!search.finished()) {
      const Stopwatch watch;
      const VectorXd tried = search.proposal();
      const bool known = first && search.state().evaluations == 0;
      auto value = known ? std::optional(*first) : residual.evaluate(tried, search.needs_jacobian());
      const bool accepted = search.tell(value);
      if (accepted) last = std::move(value);
      keep({accepted, tried, search.state().parameters, rms_of(search.state().residual_cost, residual.size()),
            watch.seconds()});
      if (checkpoint) checkpoint->write({search.state(), outcome_.trace});
    }
    return search;
  }

private:
  void keep(UpdatingStep step) {
    outcome_.trace.push_back(std::move(step));
    show_progress(static_cast<int>(outcome_.trace.size()));
    if (options_.on_updating_step)
      options_.on_updating_step(static_cast<int>(outcome_.trace.size()), outcome_.trace.back());
  }

  /// When the search will converge is not known: half of it is expected in so many evaluations.
  void show_progress(int evaluations) const {
    constexpr double half = 8.0;
    if (options_.progress)
      options_.progress("evaluation " + std::to_string(evaluations), evaluations / (evaluations + half));
  }

  const Study& study_;
  const RunOptions& options_;
  UpdatingOutcome& outcome_;
};

void end_with(Termination end, const std::string& reason, UpdatingOutcome& updating) {
  updating.end = end;
  updating.termination = reason;
  updating.converged = converged(end);
}

void end_with(const GaussNewton& search, UpdatingOutcome& updating) {
  updating.values = search.state().parameters;
  updating.iterations += search.state().iterations;
  end_with(*search.finished(), explain(*search.finished()), updating);
}

/// Continuation from wide to narrow smoothing; each step starts at the end of the one before. Only the last step keeps
/// a checkpoint.
LastResidual search_with_continuation(const Study& study, const std::vector<ComparisonResidual>& comparisons,
                                      const ResidualValue& first, const RunOptions& options,
                                      UpdatingOutcome& updating) {
  updating.method = "Gauss-Newton in a trust region";
  const std::size_t continuation_steps = continuation_steps_of(comparisons);
  VectorXd start = initial_values(study.updating->parameters);
  for (std::size_t step = 0; step + 1 < continuation_steps; ++step) {
    LeastSquaresOptions least_squares{.search = study.updating_plan->search, .start = start, .watch = {}};
    const auto outcome = minimise(sum_of(comparisons, step), study.updating->parameters, least_squares);
    updating.evaluations += outcome.evaluations;
    updating.iterations += outcome.iterations;
    start = outcome.parameters;
  }
  if (continuation_steps > 1)
    updating.method +=
        ", smoothed or local comparisons first, in " + std::to_string(continuation_steps) + " continuation steps";
  const UpdatingCheckpoint checkpoint(options.folder, fingerprint_of(study, updating.residual_initial),
                                      updating.values.size());
  LastResidual last;
  const auto done =
      TracedSearch(study, options, updating)
          .run(last_sum(comparisons), start, continuation_steps == 1 ? &first : nullptr, last, &checkpoint);
  updating.evaluations += done.state().evaluations;
  end_with(done, updating);
  return last;
}

/// Whether the modes of some comparison differ by more than noise does in one of a thousand.
bool misses_modes(const std::vector<ComparisonResidual>& comparisons, const VectorXd& values) {
  constexpr double by_noise = 0.999;
  Index row = 0;
  for (const auto& comparison : comparisons) {
    const Index size = comparison.continuation_steps.back()->size();
    const double squares = values.segment(row, size).squaredNorm() / comparison.weight;
    row += size;
    if (dynamic_cast<const ModalResidual*>(comparison.continuation_steps.back().get()) &&
        squares > chi_squared_quantile(by_noise, static_cast<double>(size)))
      return true;
  }
  return false;
}

/// The comparisons of modes and all others that need no record, with close modes joined; nothing where that changes no
/// value at a point, as no modes are close there.
std::optional<ResidualSum> with_close_modes_joined(const std::vector<ComparisonResidual>& comparisons,
                                                   const VectorXd& point) {
  std::vector<ResidualSum::Term> terms;
  bool are_close = false;
  for (const auto& comparison : comparisons) {
    const auto& residual = comparison.continuation_steps.back();
    if (const auto* modal = dynamic_cast<const ModalResidual*>(residual.get())) {
      terms.push_back({modal->with_close_modes_joined(), comparison.weight});
      const auto alone = residual->evaluate(point, false), joined = terms.back().residual->evaluate(point, false);
      are_close |= alone && joined && alone->values != joined->values;
    } else if (!comparison.of_record) {
      terms.push_back({residual, comparison.weight});
    }
  }
  return are_close ? std::optional<ResidualSum>(std::move(terms)) : std::nullopt;
}

LastResidual search_from_one_start(const Study& study, const std::vector<ComparisonResidual>& comparisons,
                                   const ResidualValue& first, const RunOptions& options, UpdatingOutcome& updating) {
  const auto& parameters = study.updating->parameters;
  const ResidualSum residual = last_sum(comparisons);
  LastResidual last = search_with_continuation(study, comparisons, first, options, updating);
  if (!last) last = residual.evaluate(updating.values, true);
  if (updating.end == Termination::budget || !last || !misses_modes(comparisons, last->values)) return last;
  const auto groups = with_close_modes_joined(comparisons, updating.values);
  if (!groups) return last;

  const auto joined = minimise(*groups, parameters, {.search = study.updating_plan->search});
  LastResidual other_last;
  const auto other =
      TracedSearch(study, options, updating).run(residual, joined.parameters, nullptr, other_last, nullptr);
  updating.evaluations += joined.evaluations + other.state().evaluations;
  updating.method += "; as modes were missed at its end, again from where close modes fit as groups";
  const double cost = 0.5 * last->values.squaredNorm() + prior_cost(parameters, updating.values);
  if (!other_last || !(other.cost() < cost)) {
    updating.method += ", which ended no lower";
    return last;
  }
  end_with(other, updating);
  return other_last;
}

/// Gauss-Newton from several starts.
LastResidual search_from_many_starts(const Study& study, const std::vector<ComparisonResidual>& comparisons,
                                     UpdatingOutcome& updating) {
  const UpdatingPlan& plan = *study.updating_plan;
  std::vector<ResidualSum> steps;
  for (std::size_t step = 0; step < continuation_steps_of(comparisons); ++step)
    steps.push_back(sum_of(comparisons, step));
  MultiStartOptions options{.starts = plan.starts, .seed = plan.seed, .search = {}};
  options.search.search = plan.search;
  for (std::size_t step = 0; step + 1 < steps.size(); ++step) options.continuation.push_back(&steps[step]);
  const auto outcome = minimise_from_many(steps.back(), study.updating->parameters, options);
  updating.values = outcome.best.parameters;
  end_with(outcome.best.termination, outcome.best.reason(), updating);
  updating.evaluations = outcome.evaluations;
  updating.iterations = outcome.best.iterations;
  updating.method = fmt::format(
      "Gauss-Newton in a trust region from {} starts, of which {} converged; they ended at {} {}", plan.starts,
      outcome.converged, outcome.minima.size(), outcome.minima.size() == 1 ? "point" : "different points");
  for (const auto& minimum : outcome.minima)
    updating.minima.push_back({minimum.parameters, rms_of(minimum.residual_cost, steps.back().size()), minimum.cost,
                               minimum.reached, minimum.converged});
  return outcome.best.residual;
}

LastResidual search_by_evolution(const Study& study, const ResidualSum& residual, UpdatingOutcome& updating) {
  const UpdatingPlan& plan = *study.updating_plan;
  EvolutionOptions options;
  options.search = plan.evolution;
  options.polishing->search = plan.search;
  const auto outcome = evolve(residual, study.updating->parameters, options);
  updating.method = "CMA-ES, then Gauss-Newton in a trust region";
  updating.values = outcome.parameters;
  if (outcome.polished) updating.end = outcome.polished->termination;
  updating.termination = outcome.reason();
  updating.converged = outcome.found() && (!outcome.polished || outcome.polished->usable());
  updating.evaluations = outcome.evaluations + (outcome.polished ? outcome.polished->evaluations : 0);
  updating.iterations = static_cast<int>(outcome.trace.size());
  if (!outcome.polished) return std::nullopt;
  return outcome.polished->residual;
}

}  // namespace

ResidualSum last_sum(const std::vector<ComparisonResidual>& comparisons) {
  return sum_of(comparisons, continuation_steps_of(comparisons) - 1);
}

double rms_of(double cost, Index size) { return std::sqrt(2.0 * cost / static_cast<double>(std::max<Index>(1, size))); }

LastResidual search(const Study& study, const std::vector<ComparisonResidual>& comparisons, const ResidualValue& first,
                    const RunOptions& options, UpdatingOutcome& updating) {
  const UpdatingPlan& plan = *study.updating_plan;
  if (plan.method == UpdatingMethod::evolution) return search_by_evolution(study, last_sum(comparisons), updating);
  if (plan.starts > 1) return search_from_many_starts(study, comparisons, updating);
  return search_from_one_start(study, comparisons, first, options, updating);
}

}  // namespace kalfem
