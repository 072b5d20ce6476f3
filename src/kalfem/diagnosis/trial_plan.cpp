// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/trial_plan.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/diagnosis/evidence.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double trials = 100.0;        ///< of a diagnosis, about
constexpr double most_work = 6e10;      ///< operations of all trials, about: decides how much of the record they see
constexpr double telling_part = 0.3;    ///< of the sum of NIS that the trials should see
constexpr Index fewest_samples = 1500;  ///< of the record, where it has as many
constexpr Index fewest_raced = 200;     ///< of it, in a race

/// Operations of one step of the filter, about.
double work_of_step(const FilterRun& run) {
  const auto n = static_cast<double>(run.choice.augmented_model->layout().size());
  const bool partially_linear = run.choice.filter == FilterKind::partially_linear ||
                                run.choice.filter == FilterKind::partially_linear_square_root;
  return partially_linear ? 50.0 * n * n : 10.0 * n * n * n;
}

/// Samples until the sum of NIS has reached a good part of its whole; where the filter stopped before the end, twice as
/// many as it reached.
Index telling_samples(const VectorXd& nis, Index samples) {
  if (nis.size() < samples) return 2 * nis.size();
  const VectorXd known = nis.array().isFinite().select(nis, 0.0);
  const double wanted = telling_part * known.sum();
  double sum = 0.0;
  for (Index k = 0; k < samples; ++k) {
    sum += known[k];
    if (sum >= wanted) return k + 1;
  }
  return samples;
}

/// First samples of the record: enough to tell what is wrong, and no more than so many trials can afford.
Index part_for(const DiagnosisInput& input, const FilterRun& run) {
  const auto affordable = static_cast<Index>(most_work / (trials * work_of_step(run)));
  const Index wanted =
      std::max(fewest_samples, std::min(affordable, telling_samples(input.nis, input.record.samples_used())));
  return std::min(input.record.samples(), wanted);
}

/// Whole parts that a race takes beside its rounds.
double passes(const TrialPlan& plan, const FilterRun& run) {
  constexpr double first_guesses = 18.0;      // of the terms of a law
  constexpr double as_given_and_best = 10.0;  // each with its further passes
  return static_cast<double>(runs_for_hypotheses(run)) + as_given_and_best + static_cast<double>(plan.finalists) +
         static_cast<double>(plan.refined) * plan.most_steps +
         static_cast<double>(plan.laws * plan.terms) * (first_guesses + 0.3 * plan.most_steps);
}

}  // namespace

std::vector<TrialPlan::Round> TrialPlan::rounds(std::size_t hypotheses, std::size_t starts) const {
  const auto share = [&](std::size_t runs) {
    return static_cast<Index>(std::min(1.0, raced / static_cast<double>(runs)) * static_cast<double>(samples));
  };
  const std::size_t second = std::max(finalists, hypotheses / 3);
  std::vector<Round> all{{hypotheses, share(starts)}};
  if (all.back().samples < samples && second < hypotheses) all.push_back({second, share(second)});
  if (all.back().samples < samples) all.push_back({finalists, samples});
  return all;
}

std::optional<TrialPlan> plan_for(const DiagnosisInput& input, const FilterRun& run) {
  TrialPlan plan{.substeps = input.problem->settings.substeps.value_or(1), .samples = part_for(input, run)};
  if (!std::isfinite(input.steps)) return plan;
  plan.finalists = 6;
  plan.refined = 2;
  plan.most_steps = 5;
  plan.laws = 1;
  plan.terms = 2;
  plan.raced = 15.0;
  const double parts = passes(plan, run) + 2.0 * plan.raced;
  const auto affordable = [&] { return static_cast<Index>(input.steps / (parts * plan.substeps)); };
  while (plan.substeps > 1 && affordable() < std::min(plan.samples, fewest_samples)) plan.substeps /= 2;
  plan.samples = std::min(plan.samples, affordable());
  return plan.samples < std::min(fewest_raced, input.record.samples()) ? std::nullopt : std::optional(plan);
}

TrialPlan plan_of_next(TrialPlan plan) {
  plan.finalists = 6;
  plan.refined = 3;
  plan.most_steps = 7;
  plan.laws = 1;
  plan.terms = 2;
  plan.raced = 20.0;
  plan.searches_early = true;
  return plan;
}

}  // namespace kalfem
