// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/process_noise_study.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// On the stated noise; those that the verdict asks for come first.
constexpr std::array factors{1.0 / 3.0, 3.0, 0.1, 10.0};
constexpr std::size_t needed = 2;  ///< for a verdict

ProcessNoiseTrial trial_of(double factor, const EstimationResult& result, const ConsistencySummary& consistency,
                           const AugmentedModel& model, Index settled) {
  const auto& [mean, deviation] = result.unknowns;
  ProcessNoiseTrial trial{.factor = factor,
                          .log_likelihood = result.log_likelihood,
                          .mean_nis = consistency.mean_nis,
                          .estimates = mean.rightCols(1),
                          .deviations = deviation.rightCols(1)};
  for (Index i = 0; i < mean.rows(); ++i) {
    if (!(model.options().unknowns[static_cast<std::size_t>(i)].random_walk > 0.0)) continue;
    trial.estimates[i] = mean.row(i).tail(mean.cols() - settled).mean();
    trial.deviations[i] = deviation.row(i).tail(mean.cols() - settled).mean();
  }
  return trial;
}

/// The filter of the estimate with its process noise times the factor, over the same samples.
std::optional<ProcessNoiseTrial> trial_with(double factor, const EstimationProblemPtr& problem,
                                            AugmentedModelSetup setup, const Record& record,
                                            const RecordEstimate& estimate) {
  setup.options.process_noise.acceleration *= factor;
  setup.options.substeps = estimate.substeps.substeps;
  setup.starts_at_rest = !estimate.start.moving;
  EstimationOptions options{.unscented = problem->settings.unscented,
                            .passes = problem->settings.passes,
                            .state_deviations = false,
                            .adaptive_noise = problem->settings.adaptive_noise,
                            .held_out = estimate.held_out};
  options.outliers.treatment = estimate.outliers;
  const auto filtered = run_filter(problem, setup, record, options);
  const auto& result = filtered.result;
  if (result.failure) return std::nullopt;
  const auto consistency = summarise_consistency(result.nis, result.measured, result.innovation,
                                                 filtered.run.input.measured.noise(), estimate.settled);
  return trial_of(factor, result, consistency, *filtered.augmented_model(), estimate.settled);
}

}  // namespace

ProcessNoiseStudy study_process_noise(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                      const Record& record, const RecordEstimate& estimate, StepBudget& budget) {
  const bool any_noise = (setup.options.process_noise.acceleration.array() > 0.0).any();
  if (problem->settings.adaptive_noise.process) return {};  // the record decides
  if (estimate.result.failure || !any_noise || estimate.augmented_model->layout().unknowns == 0) return {};
  const double steps = steps_of_run(*problem, record, estimate.substeps.substeps);
  std::size_t allowed = 0;
  while (allowed < factors.size() && budget.take(steps)) ++allowed;
  ProcessNoiseStudy study{.stopped = allowed < needed};
  if (allowed == 0) return study;
  std::vector<std::optional<ProcessNoiseTrial>> found(allowed);
  for_each_index(allowed, filter_threads(problem->settings),
                 [&](std::size_t i) { found[i] = trial_with(factors[i], problem, setup, record, estimate); });
  study.trials = {trial_of(1.0, estimate.result, estimate.consistency, *estimate.augmented_model, estimate.settled)};
  for (auto& each : found)
    if (each) study.trials.push_back(std::move(*each));
  std::ranges::sort(study.trials, {}, &ProcessNoiseTrial::factor);
  return study;
}

}  // namespace kalfem
