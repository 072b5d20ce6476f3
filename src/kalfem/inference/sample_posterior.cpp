// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/sample_posterior.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kalfem/sampling/adaptive_metropolis.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/sampling/laplace.hpp"
#include "kalfem/sampling/tempered_sampler.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int chains = 4;
constexpr int pilot_samples = 200;  ///< by importance sampling, from which Markov chains start

constexpr int search_steps = 30;   ///< a rough likelihood has no maximum to converge to; the samples mend the rest
constexpr int further_starts = 2;  ///< of the search for the maximum, where its samples do not hold

/// One sample of the normal distribution inside the prior's support; the mode where 1000 tries lie outside.
VectorXd normal_sample(const Posterior& posterior, const LaplaceMode& about, const MatrixXd& factor,
                       RandomStream& random) {
  for (int tries = 0; tries < 1000; ++tries) {
    const VectorXd normal = VectorXd::NullaryExpr(about.mode.size(), [&] { return random.normal(); });
    const VectorXd drawn = about.mode + factor * normal;
    if (std::isfinite(posterior.prior.log_density(drawn))) return drawn;
  }
  return about.mode;
}

/// Samples of the normal distributions about the modes, of each as many as its weight says.
SampleSet normal_samples(const Posterior& posterior, const std::vector<LaplaceMode>& about, const VectorXd& weights,
                         const InferenceProblem& problem) {
  std::vector<MatrixXd> factors;
  for (const auto& mode : about) factors.emplace_back(Eigen::LLT<MatrixXd>(mode.covariance).matrixL());
  MatrixXd z(posterior.prior.size(), problem.samples);
  VectorXd log_likelihood(problem.samples);
  std::size_t d = 0;
  double reached = weights[0];
  for (Index k = 0; k < problem.samples; ++k) {
    while (d + 1 < about.size() && (static_cast<double>(k) + 0.5) / problem.samples >= reached)
      reached += weights[static_cast<Index>(++d)];
    RandomStream random(problem.seed, "laplace " + std::to_string(k));
    z.col(k) = posterior.prior.to_standard_normal(normal_sample(posterior, about[d], factors[d], random));
    log_likelihood[k] = about[d].log_likelihood;
  }
  return make_sample_set(posterior.prior, z, log_likelihood, 1);
}

/// Weights by Z of the modes.
VectorXd shares_of(const std::vector<LaplaceMode>& modes) {
  VectorXd log_evidence(std::ssize(modes));
  for (Index k = 0; k < log_evidence.size(); ++k) log_evidence[k] = *modes[static_cast<std::size_t>(k)].log_evidence;
  return model_probabilities(log_evidence);
}

void by_laplace(const InferenceProblem& problem, const Posterior& posterior, const VectorXd& start,
                const SamplingEffort& effort, InferenceResult& result) {
  const auto laplace = laplace_approximation(posterior, {.search_likelihoods = effort.search_likelihoods,
                                                         .seed = problem.seed,
                                                         .start = start,
                                                         .threads = effort.threads});
  result.method = "normal distribution about the most probable values (Laplace)";
  result.warnings.insert(result.warnings.end(), laplace.warnings.begin(), laplace.warnings.end());
  result.evaluations = laplace.evaluations;
  result.most_probable = laplace.mode;
  result.log_likelihood = laplace.log_likelihood;
  result.log_evidence = laplace.log_evidence_of_all();
  result.prior_starts = laplace.prior_starts;
  if (!laplace.log_evidence) {
    if (!laplace.others.empty())
      result.warnings.emplace_back("further maxima were found, whose weights beside the highest are not known; sample");
    if (laplace.covariance.size() == 0) return;
  }
  std::vector<LaplaceMode> modes{laplace};
  if (laplace.log_evidence) modes.insert(modes.end(), laplace.others.begin(), laplace.others.end());
  const VectorXd shares = modes.size() > 1 ? shares_of(modes) : VectorXd::Ones(1);
  result.samples = normal_samples(posterior, modes, shares, problem);
  if (modes.size() > 1) result.method = "normal distributions about the maxima (Laplace), weighted by their evidence";
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double share = shares[static_cast<Index>(k)];
    if (share < least_mode_weight) continue;
    result.modes.push_back(
        {share, modes[k].mode, modes[k].mode, modes[k].covariance.diagonal().cwiseMax(0.0).cwiseSqrt()});
  }
  result.modes = told_apart(std::move(result.modes));
}

void by_importance(const InferenceProblem& problem, const Posterior& posterior, const VectorXd& start,
                   const SamplingEffort& effort, const Progress& progress, InferenceResult& result) {
  ImportanceOptions options{.samples = problem.samples,
                            .max_iterations = search_steps,
                            .search_likelihoods = effort.search_likelihoods,
                            .start = start,
                            .seed = problem.seed,
                            .threads = effort.threads};
  auto found = sample_importance(posterior, options, progress);
  result.evaluations = found.evaluations;
  if (!found.reliable() && options.search_likelihoods == 0) {  // the search may have ended on a side maximum
    options.random_starts = further_starts;
    auto wider = sample_importance(posterior, options, progress);
    result.evaluations += wider.evaluations;
    if (wider.log_evidence > found.log_evidence) found = std::move(wider);
  }
  result.method = "importance samples about the most probable values";
  result.samples = std::move(found.samples);
  result.log_evidence = found.log_evidence;
  result.log_evidence_deviation = found.log_evidence_deviation;
  result.effective_samples = found.effective_samples;
  result.pareto_k = found.k_hat;
  result.modes = std::move(found.modes);
  result.prior_starts = found.prior_starts;
  result.warnings.insert(result.warnings.end(), found.warnings.begin(), found.warnings.end());
}

/// The exponent goes from 0 to 1 in steps that shrink at first, so its square root shows how far the run is.
void by_tempering(const InferenceProblem& problem, const Posterior& posterior, int threads, const Progress& progress,
                  InferenceResult& result) {
  TemperedOptions options = tempered_options_for_expensive_likelihoods(problem.samples);
  options.seed = problem.seed;
  options.threads = threads;
  auto found = sample_tempered(posterior, options, [&](const TemperedState& state) {
    if (progress) progress("tempering", std::sqrt(state.exponent));
  });
  result.method = "transitional Markov chain Monte Carlo";
  result.samples = std::move(found.samples);
  result.log_evidence = found.log_evidence;
  result.log_evidence_deviation = found.log_evidence_deviation;
  result.evaluations = found.state.evaluations;
  if (!found.state.stages.empty()) result.acceptance = found.state.stages.back().acceptance;
  if (!found.finished) result.warnings.emplace_back("tempering did not reach the posterior: take more samples");
}

void by_chains(const InferenceProblem& problem, const Posterior& posterior, const VectorXd& start,
               const SamplingEffort& effort, const Progress& progress, InferenceResult& result) {
  const int threads = effort.threads;
  const auto pilot = sample_importance(posterior, {.samples = pilot_samples,
                                                   .search_likelihoods = effort.search_likelihoods,
                                                   .start = start,
                                                   .seed = problem.seed,
                                                   .threads = threads});
  const int draws = std::max(50, (problem.samples + chains - 1) / chains);
  const MetropolisOptions options{.chains = chains,
                                  .warm_up = std::max(50, draws / 4),
                                  .draws = draws,
                                  .block = 10,
                                  .start = pilot.approximation,
                                  .seed = problem.seed,
                                  .threads = threads};
  const double all = options.warm_up + options.draws;
  auto found = sample_metropolis(posterior, options, [&](const MetropolisState& state) {
    if (progress) progress("chains", state.done / all);
  });
  result.method = "four adaptive Markov chains";
  if (pilot.modes.size() > 1)
    result.warnings.push_back(
        fmt::format("the posterior has {} separate maxima, between which chains do not move: their shares do not hold; "
                    "take method: importance or tempered",
                    pilot.modes.size()));
  result.samples = std::move(found.samples);
  result.convergence = found.convergence;
  result.acceptance = found.acceptance.mean();
  result.evaluations = pilot.evaluations + found.state.evaluations;
  if (!found.converged)
    result.warnings.emplace_back(
        "the chains are too short, or have not met: R-hat above 1.01, or fewer than 100 effective draws a chain; take "
        "more samples");
}

/// The sample with the largest p(data | theta) p(theta).
void set_most_probable(InferenceResult& result) {
  const auto& samples = result.samples;
  if (result.most_probable.size() > 0 || samples.values.cols() == 0) return;
  Index best = 0;
  (samples.log_likelihood + samples.log_prior).maxCoeff(&best);
  result.most_probable = samples.values.col(best);
  result.log_likelihood = samples.log_likelihood[best];
}

}  // namespace

VectorXd InferenceResult::centre() const {
  if (modes.size() > 1) return modes.front().mean;
  VectorXd means(std::ssize(posterior));
  for (Index i = 0; i < means.size(); ++i) means[i] = posterior[static_cast<std::size_t>(i)].mean;
  return means;
}

void sample_posterior(const InferenceProblem& problem, const Posterior& posterior, const VectorXd& start,
                      const SamplingEffort& effort, const Progress& progress, InferenceResult& result) {
  switch (problem.method) {
    case PosteriorMethod::filter:
      throw std::logic_error("the filter's posterior is not sampled: take_filter_posterior()");
    case PosteriorMethod::laplace:
      by_laplace(problem, posterior, start, effort, result);
      break;
    case PosteriorMethod::importance:
      by_importance(problem, posterior, start, effort, progress, result);
      break;
    case PosteriorMethod::tempered:
      by_tempering(problem, posterior, effort.threads, progress, result);
      break;
    case PosteriorMethod::metropolis:
      by_chains(problem, posterior, start, effort, progress, result);
      break;
  }
  if (result.modes.size() < 2) result.modes.clear();
  set_most_probable(result);
  summarise_posterior(result);
}

std::vector<ParameterSummary> summarise_prior(const JointPrior& prior) {
  std::vector<ParameterSummary> summaries;
  for (const auto& [name, marginal] : prior.marginals())
    summaries.push_back({name, mean(marginal), deviation(marginal), from_normal(marginal, -1.959963984540054),
                         from_normal(marginal, -0.994457883209753), from_normal(marginal, 0.0),
                         from_normal(marginal, 0.994457883209753), from_normal(marginal, 1.959963984540054)});
  return summaries;
}

void summarise_posterior(InferenceResult& result) {
  if (result.samples.values.cols() == 0) return;
  result.posterior = summarise_samples(result.samples);
  result.correlation = posterior_correlation(result.samples);
}

}  // namespace kalfem
