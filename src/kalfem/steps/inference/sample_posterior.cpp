// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kalfem/sampling/adaptive_metropolis.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/sampling/laplace.hpp"
#include "kalfem/sampling/tempered_sampler.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int chains = 4;
constexpr int pilot_samples = 200;  ///< by importance sampling, from which Markov chains start

constexpr int search_steps = 30;   ///< a rough likelihood has no maximum to converge to; the samples mend the rest
constexpr int further_starts = 2;  ///< of the search for the maximum, where its samples do not hold

/// Samples of the normal distribution inside the prior's support.
SampleSet normal_samples(const Posterior& posterior, const LaplaceApproximation& laplace, const InferencePlan& plan) {
  const Index size = laplace.mode.size();
  const MatrixXd factor = Eigen::LLT<MatrixXd>(laplace.covariance).matrixL();
  MatrixXd z(size, plan.samples);
  for (Index k = 0; k < plan.samples; ++k) {
    RandomStream random(plan.seed, "laplace " + std::to_string(k));
    VectorXd theta = laplace.mode;
    for (int tries = 0; tries < 1000; ++tries) {
      const VectorXd normal = VectorXd::NullaryExpr(size, [&] { return random.normal(); });
      const VectorXd drawn = laplace.mode + factor * normal;
      if (!std::isfinite(posterior.prior.log_density(drawn))) continue;
      theta = drawn;
      break;
    }
    z.col(k) = posterior.prior.to_standard_normal(theta);
  }
  return make_sample_set(posterior.prior, z, VectorXd::Constant(plan.samples, laplace.log_likelihood), 1);
}

void by_laplace(const InferencePlan& plan, const Posterior& posterior, const VectorXd& start, int threads,
                InferenceOutcome& outcome) {
  const auto laplace = laplace_approximation(posterior, {.seed = plan.seed, .start = start, .threads = threads});
  outcome.method = "normal distribution about the most probable values (Laplace)";
  outcome.warnings.insert(outcome.warnings.end(), laplace.warnings.begin(), laplace.warnings.end());
  outcome.evaluations = laplace.evaluations;
  outcome.most_probable = laplace.mode;
  outcome.log_likelihood = laplace.log_likelihood;
  outcome.log_evidence = laplace.log_evidence;
  if (laplace.covariance.size() > 0) outcome.samples = normal_samples(posterior, laplace, plan);
}

void by_importance(const InferencePlan& plan, const Posterior& posterior, const VectorXd& start, int threads,
                   const Progress& progress, InferenceOutcome& outcome) {
  ImportanceOptions options{
      .samples = plan.samples, .max_iterations = search_steps, .start = start, .seed = plan.seed, .threads = threads};
  auto found = sample_importance(posterior, options, progress);
  outcome.evaluations = found.evaluations;
  if (!found.reliable()) {  // the search may have ended on a side maximum
    options.random_starts = further_starts;
    auto wider = sample_importance(posterior, options, progress);
    outcome.evaluations += wider.evaluations;
    if (wider.log_evidence > found.log_evidence) found = std::move(wider);
  }
  outcome.method = "importance samples about the most probable values";
  outcome.samples = std::move(found.samples);
  outcome.log_evidence = found.log_evidence;
  outcome.log_evidence_deviation = found.log_evidence_deviation;
  outcome.effective_samples = found.effective_samples;
  outcome.pareto_k = found.k_hat;
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
}

/// The exponent goes from 0 to 1 in steps that shrink at first, so its square root shows how far the run is.
void by_tempering(const InferencePlan& plan, const Posterior& posterior, int threads, const Progress& progress,
                  InferenceOutcome& outcome) {
  TemperedOptions options = tempered_options_for_expensive_likelihoods(plan.samples);
  options.seed = plan.seed;
  options.threads = threads;
  auto found = sample_tempered(posterior, options, [&](const TemperedState& state) {
    if (progress) progress("tempering", std::sqrt(state.exponent));
  });
  outcome.method = "transitional Markov chain Monte Carlo";
  outcome.samples = std::move(found.samples);
  outcome.log_evidence = found.log_evidence;
  outcome.log_evidence_deviation = found.log_evidence_deviation;
  outcome.evaluations = found.state.evaluations;
  if (!found.state.stages.empty()) outcome.acceptance = found.state.stages.back().acceptance;
  if (!found.finished) outcome.warnings.emplace_back("tempering did not reach the posterior: take more samples");
}

void by_chains(const InferencePlan& plan, const Posterior& posterior, const VectorXd& start, int threads,
               const Progress& progress, InferenceOutcome& outcome) {
  const auto pilot =
      sample_importance(posterior, {.samples = pilot_samples, .start = start, .seed = plan.seed, .threads = threads});
  const int draws = std::max(50, (plan.samples + chains - 1) / chains);
  const MetropolisOptions options{.chains = chains,
                                  .warm_up = std::max(50, draws / 4),
                                  .draws = draws,
                                  .block = 10,
                                  .start = pilot.approximation,
                                  .seed = plan.seed,
                                  .threads = threads};
  const double all = options.warm_up + options.draws;
  auto found = sample_metropolis(posterior, options, [&](const MetropolisState& state) {
    if (progress) progress("chains", state.done / all);
  });
  outcome.method = "four adaptive Markov chains";
  outcome.samples = std::move(found.samples);
  outcome.convergence = found.convergence;
  outcome.acceptance = found.acceptance.mean();
  outcome.evaluations = pilot.evaluations + found.state.evaluations;
  if (!found.converged)
    outcome.warnings.emplace_back(
        "the chains are too short, or have not met: R-hat above 1.01, or fewer than 100 effective draws a chain; take "
        "more samples");
}

/// The sample with the largest p(data | theta) p(theta).
void set_most_probable(InferenceOutcome& outcome) {
  const auto& samples = outcome.samples;
  if (outcome.most_probable.size() > 0 || samples.values.cols() == 0) return;
  Index best = 0;
  (samples.log_likelihood + samples.log_prior).maxCoeff(&best);
  outcome.most_probable = samples.values.col(best);
  outcome.log_likelihood = samples.log_likelihood[best];
}

}  // namespace

void sample_posterior(const InferencePlan& plan, const Posterior& posterior, const VectorXd& start, int threads,
                      const Progress& progress, InferenceOutcome& outcome) {
  switch (plan.method) {
    case PosteriorMethod::filter:
      throw std::logic_error("the filter's posterior is not sampled: take_filter_posterior()");
    case PosteriorMethod::laplace:
      by_laplace(plan, posterior, start, threads, outcome);
      break;
    case PosteriorMethod::importance:
      by_importance(plan, posterior, start, threads, progress, outcome);
      break;
    case PosteriorMethod::tempered:
      by_tempering(plan, posterior, threads, progress, outcome);
      break;
    case PosteriorMethod::metropolis:
      by_chains(plan, posterior, start, threads, progress, outcome);
      break;
  }
  set_most_probable(outcome);
  summarise_posterior(outcome);
}

void summarise_posterior(InferenceOutcome& outcome) {
  if (outcome.samples.values.cols() == 0) return;
  outcome.posterior = summarise_samples(outcome.samples);
  outcome.correlation = posterior_correlation(outcome.samples);
}

}  // namespace kalfem
