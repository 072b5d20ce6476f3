// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/compute.hpp"

#include <cmath>

#include <fmt/format.h>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/inference/case_likelihood.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/posterior.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

ParameterSummary summary_of(const std::string& name, const MarginalPrior& prior) {
  return {name,
          mean(prior),
          deviation(prior),
          from_normal(prior, -1.959963984540054),
          from_normal(prior, -0.994457883209753),
          from_normal(prior, 0.0),
          from_normal(prior, 0.994457883209753),
          from_normal(prior, 1.959963984540054)};
}

/// The samples of the record, or of the simulation that makes one, without channels where there are none yet.
Record time_of(const Study& study) {
  if (study.record) return study.record->record;
  Record time{.sample_rate = study.simulation->sample_rate};
  time.values.resize(0, std::llround(study.simulation->duration * time.sample_rate) + 1);
  return time;
}

std::vector<InformedParameter> informed(const InferencePlan& plan, const VectorXd& values) {
  const VectorXd deviation = plan.prior.deviation();
  std::vector<InformedParameter> parameters;
  for (Index i = 0; i < values.size(); ++i)
    parameters.push_back({plan.parameters[static_cast<std::size_t>(i)].name, values[i], deviation[i]});
  return parameters;
}

/// The filter's unknowns at the record's end, and those that a search found, beside the posterior.
std::vector<FilterComparison> beside_filter(const InferenceOutcome& outcome, const RecordEstimate& estimate) {
  std::vector<FilterComparison> all;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (const auto& posterior : outcome.posterior) {
    FilterComparison comparison{.name = posterior.name};
    const auto found = std::ranges::find(unknowns, posterior.name, &UnknownParameter::name);
    if (found != unknowns.end()) {
      const Index row = found - unknowns.begin();
      comparison.filter_mean = estimate.result.unknowns.mean(row, Eigen::last);
      comparison.filter_deviation = estimate.result.unknowns.deviation(row, Eigen::last);
    } else if (estimate.likelihood) {
      const auto& searched = estimate.likelihood->unknowns;
      const auto place = std::ranges::find(searched, posterior.name, &LikelihoodUnknown::name);
      if (place == searched.end()) continue;
      comparison.filter_mean = estimate.likelihood->values[place - searched.begin()];
      comparison.filter_deviation = estimate.likelihood->deviation[place - searched.begin()];
    } else {
      continue;
    }
    comparison.mean_difference = (posterior.mean - comparison.filter_mean) / posterior.deviation;
    comparison.deviation_ratio = comparison.filter_deviation / posterior.deviation;
    all.push_back(comparison);
  }
  return all;
}

std::vector<ProfileLikelihood> profiles_of(const InferencePlan& plan, const Posterior& posterior,
                                           const InferenceOutcome& outcome, int threads) {
  VectorXd deviation(std::ssize(outcome.posterior));
  for (Index i = 0; i < deviation.size(); ++i) deviation[i] = outcome.posterior[static_cast<std::size_t>(i)].deviation;
  std::vector<ProfileLikelihood> profiles;
  for (const std::size_t i : plan.profile) {
    ProfileLikelihood profile;
    static_cast<Profile&>(profile) =
        profile_likelihood(posterior, static_cast<Index>(i), outcome.most_probable, deviation, {.threads = threads});
    profile.name = plan.parameters[i].name;
    profile.unit = plan.parameters[i].unit;
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

/// Whether the filter has a normal distribution of its own beside the posterior.
bool has_filter_beside(const InferencePlan& plan, const RecordEstimate* estimate) {
  return plan.likelihood == LikelihoodKind::filter && plan.method != PosteriorMethod::filter && estimate &&
         !estimate->result.failure;
}

std::optional<Identifiability> judged(const InferencePlan& plan, const CaseLikelihood& likelihood,
                                      const VectorXd& theta) {
  const auto information = likelihood.information(theta);
  if (!information || !information->allFinite()) return std::nullopt;
  return identifiability(*information, informed(plan, theta));
}

}  // namespace

std::optional<Identifiability> identifiability_before(const Study& study) {
  const auto& plan = *study.inference;
  if (plan.likelihood == LikelihoodKind::comparisons || !study.problem) return std::nullopt;
  IssueList unknown;
  check_excitation_is_known(*study.problem, unknown);
  if (!unknown.empty()) return std::nullopt;
  const VectorXd start = start_of(plan);
  const auto expected = expected_record(study.problem, time_of(study), names_of(plan), start);
  if (!expected) return std::nullopt;
  const FilterLikelihood likelihood(study.problem, *expected, names_of(plan), {.first = start});
  const auto information = fisher_information(
      likelihood, start, {.scale = plan.prior.deviation(), .threads = filter_threads(study.problem->settings)});
  if (!information || !information->allFinite()) return std::nullopt;
  return identifiability(*information, informed(plan, start));
}

// 1. What the record can tell, before it is looked at.
// 2. The posterior by the plan's method, and what it says of identifiability, of the record, and beside the filter.
// 3. Which law, and which unknown matters to which output.
InferenceOutcome run_inference(const Study& study, const StudyResults& results, const RunOptions& options) {
  const Stopwatch watch;
  const auto& plan = *study.inference;
  const bool of_record = plan.likelihood != LikelihoodKind::comparisons;
  const int threads = study.problem ? filter_threads(study.problem->settings) : processors();
  LikelihoodCheckpoint checkpoint(options.folder);
  const double posterior_share = plan.laws.empty() ? 1.0 : 1.0 / static_cast<double>(1 + plan.laws.size());
  const Progress of_posterior = part_of(options.progress, 0.0, posterior_share);
  InferenceOutcome outcome;
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    outcome.units.push_back(plan.parameters[i].unit);
    outcome.truths.push_back(plan.parameters[i].truth);
    outcome.prior.push_back(summary_of(plan.parameters[i].name, plan.prior.marginals()[i].second));
    outcome.prior_marginals.push_back(plan.prior.marginals()[i].second);
  }
  if (of_record) outcome.before = identifiability_before(study);
  const RecordEstimate* estimate = results.find<EstimationOutcome>();
  const CaseLikelihood likelihood =
      of_record ? posterior_of_record(study, record_of(study, results), estimate, checkpoint, of_posterior, outcome)
                : posterior_of_comparisons(study, results, checkpoint, of_posterior, outcome);
  outcome.likelihood = likelihood.words;
  if (!outcome.posterior.empty()) {
    outcome.after = judged(plan, likelihood, outcome.centre());
    if (has_filter_beside(plan, estimate)) outcome.beside_filter = beside_filter(outcome, *estimate);
    outcome.profiles = profiles_of(plan, {plan.prior, likelihood.log_likelihood}, outcome, threads);
    if (of_record) {
      outcome.bands = predictive_bands(study, record_of(study, results), outcome.samples, threads);
      if (outcome.bands.empty() && plan.predictions > 0 && can_be_simulated(study))
        outcome.warnings.push_back(
            fmt::format("predictions: {}: no draw of the posterior could be simulated from rest to the record's end, "
                        "so there are no "
                        "bands of the response; simulate fewer seconds, or set predictions: 0",
                        plan.predictions));
    }
  }
  if (!plan.laws.empty())
    outcome.laws =
        rank_laws(study, record_of(study, results), checkpoint, part_of(options.progress, posterior_share, 1.0));
  if (plan.sensitivity) outcome.sensitivity = output_sensitivity(study, record_of(study, results), threads);
  if (!outcome.sensitivity.empty() && outcome.sensitivity.front().indices.left_out > 0)
    outcome.warnings.push_back(fmt::format(
        "sensitivity: the outputs cannot be computed at {} of {} samples of the priors, which the indices leave out; "
        "narrow the priors to values at which the structure is possible",
        outcome.sensitivity.front().indices.left_out, plan.sensitivity->samples));
  outcome.evaluations_before = checkpoint.from_earlier();
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
