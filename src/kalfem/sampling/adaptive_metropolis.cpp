// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/adaptive_metropolis.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "kalfem/base/parallel.hpp"
#include "kalfem/sampling/student_mixture.hpp"

// Chains are advanced block by block, side by side. Every block of a chain draws from a stream of its own, so that a
// stored state continues with the same numbers. In the warm-up the gains of the mean, the covariance and the scale fall
// with the number of draws as k^-0.6; afterwards the kernel is fixed and the chain an ordinary Markov chain. A known
// start counts as draws made before: its covariance is worth more than that of a few correlated draws.

namespace kalfem {
namespace {

constexpr int most_starts = 1000;
constexpr double draws_of_start = 1000.0;  ///< that a known mean and covariance are worth
constexpr int degrees = 5;                 ///< of freedom of the starts about it

/// Where chains start: a Student t distribution with twice the known deviations, or the prior.
StudentDistribution starts_of(const MetropolisOptions& options, Eigen::Index size) {
  if (!options.start) return {{Eigen::VectorXd::Zero(size), Eigen::MatrixXd::Identity(size, size)}, 0};
  constexpr double variance = degrees / (degrees - 2.0);  // of the t distribution with a scale of one
  return {{options.start->mean, 4.0 / variance * options.start->covariance}, degrees};
}

MetropolisChain start_chain(const Posterior& posterior, const MetropolisOptions& options, int number) {
  RandomStream random(options.seed, "metropolis start " + std::to_string(number));
  const Eigen::Index size = posterior.prior.size();
  const StudentDistribution starts = starts_of(options, size);
  MetropolisChain chain;
  for (int k = 0; k < most_starts; ++k) {
    stop_if_asked();
    chain.z = starts.draw(random);
    chain.log_likelihood = posterior.log_likelihood_of(chain.z);
    if (std::isfinite(chain.log_likelihood)) break;
  }
  if (!std::isfinite(chain.log_likelihood))
    throw InvalidInput("none of " + std::to_string(most_starts) + " samples of the " +
                           (options.start ? "start" : "prior") + " has a likelihood",
                       "a chain has nowhere to start", "check the model and the prior's bounds");
  chain.mean = options.start ? options.start->mean : chain.z;
  chain.covariance = options.start ? options.start->covariance : Eigen::MatrixXd::Identity(size, size);
  chain.log_scale = std::log(2.38 / std::sqrt(static_cast<double>(size)));
  return chain;
}

/// How likely the proposal was accepted.
double move(const Posterior& posterior, MetropolisChain& chain, const Eigen::MatrixXd& factor, RandomStream& random) {
  Eigen::VectorXd step(chain.z.size());
  for (auto& value : step) value = random.normal();
  const double uniform = random.uniform();
  const Eigen::VectorXd proposed = chain.z + std::exp(chain.log_scale) * (factor * step);
  const double value = posterior.log_likelihood_of(proposed);
  if (!std::isfinite(value)) return 0.0;
  const double log_ratio = value - chain.log_likelihood + 0.5 * (chain.z.squaredNorm() - proposed.squaredNorm());
  const double acceptance = std::exp(std::min(0.0, log_ratio));
  if (uniform < acceptance) {
    chain.z = proposed;
    chain.log_likelihood = value;
  }
  return acceptance;
}

void adapt(MetropolisChain& chain, double acceptance, int draw, const MetropolisOptions& options) {
  const double scale_gain = std::pow(draw + (options.start ? 100.0 : 2.0), -0.6);
  const double gain = options.start ? 1.0 / (draws_of_start + draw) : scale_gain;
  chain.log_scale += scale_gain * (acceptance - options.acceptance);
  const Eigen::VectorXd off = chain.z - chain.mean;
  chain.mean += gain * off;
  chain.covariance += gain * (off * off.transpose() - chain.covariance);
}

/// Draws `begin` to `end` of a chain.
void run_block(const Posterior& posterior, const MetropolisOptions& options, MetropolisChain& chain, int number,
               int begin, int end) {
  RandomStream random(options.seed, "metropolis " + std::to_string(number) + " " + std::to_string(begin));
  const auto factor = [&] {
    Eigen::MatrixXd covariance = chain.covariance;
    covariance.diagonal().array() += 1e-10 * covariance.diagonal().maxCoeff() + 1e-300;
    return Eigen::MatrixXd(covariance.llt().matrixL());
  };
  Eigen::MatrixXd current = factor();
  for (int draw = begin; draw < end; ++draw) {
    stop_if_asked();
    const Eigen::VectorXd before = chain.z;
    const double acceptance = move(posterior, chain, current, random);
    if (draw < options.warm_up) {
      adapt(chain, acceptance, draw, options);
      current = factor();
      continue;
    }
    chain.accepted += chain.z != before ? 1 : 0;
    chain.draws.col(draw - options.warm_up) = chain.z;
    chain.draws_log_likelihood[draw - options.warm_up] = chain.log_likelihood;
  }
}

void advance(const Posterior& posterior, const MetropolisOptions& options, MetropolisState& state) {
  const int end = std::min(state.done + options.block, options.warm_up + options.draws);
  MetropolisState next = state;
  for_each_index(next.chains.size(), options.threads, [&](std::size_t k) {
    auto& chain = next.chains[k];
    const int kept = std::max(0, end - options.warm_up);
    chain.draws.conservativeResize(chain.z.size(), kept);
    chain.draws_log_likelihood.conservativeResize(kept);
    run_block(posterior, options, chain, static_cast<int>(k), state.done, end);
  });
  next.evaluations += static_cast<long long>(end - state.done) * static_cast<long long>(next.chains.size());
  next.done = end;
  state = std::move(next);
}

MetropolisState begin(const Posterior& posterior, const MetropolisOptions& options) {
  MetropolisState state;
  state.chains.resize(static_cast<std::size_t>(options.chains));
  for_each_index(state.chains.size(), options.threads,
                 [&](std::size_t k) { state.chains[k] = start_chain(posterior, options, static_cast<int>(k)); });
  state.evaluations = options.chains;
  return state;
}

MetropolisResult result_of(const Posterior& posterior, const MetropolisOptions& options, MetropolisState state) {
  const Eigen::Index draws = options.draws, chains = options.chains;
  Eigen::MatrixXd z(posterior.prior.size(), draws * chains);
  Eigen::VectorXd log_likelihood(draws * chains);
  MetropolisResult result;
  result.acceptance.resize(chains);
  for (Eigen::Index c = 0; c < chains; ++c) {
    const auto& chain = state.chains[static_cast<std::size_t>(c)];
    z.middleCols(c * draws, draws) = chain.draws;
    log_likelihood.segment(c * draws, draws) = chain.draws_log_likelihood;
    result.acceptance[c] = static_cast<double>(chain.accepted) / static_cast<double>(draws);
  }
  result.samples = make_sample_set(posterior.prior, z, log_likelihood, chains);
  for (Eigen::Index i = 0; i < z.rows(); ++i) result.convergence.push_back(convergence_of(result.samples.draws_of(i)));
  result.converged = std::all_of(result.convergence.begin(), result.convergence.end(),
                                 [&](const Convergence& convergence) { return convergence.reached(chains); });
  result.state = std::move(state);
  return result;
}

void check_start(const NormalApproximation& start, const JointPrior& prior) {
  const Eigen::Index size = prior.size();
  if (start.mean.size() == size && start.covariance.rows() == size && start.covariance.cols() == size &&
      start.mean.allFinite() && start.covariance.allFinite() &&
      Eigen::LLT<Eigen::MatrixXd>(start.covariance).info() == Eigen::Success)
    return;
  throw InvalidInput("the start of the chains has no mean of " + std::to_string(size) +
                         " values and positive definite covariance of as many rows",
                     "chains start about this mean", "give both over z, or leave the start out");
}

void check_state(const MetropolisState& state, const Posterior& posterior, const MetropolisOptions& options) {
  const auto of_size = [&](const MetropolisChain& chain) { return chain.z.size() == posterior.prior.size(); };
  if (static_cast<int>(state.chains.size()) == options.chains && state.done <= options.warm_up + options.draws &&
      std::all_of(state.chains.begin(), state.chains.end(), of_size))
    return;
  throw InvalidInput("the stored state, " + std::to_string(state.chains.size()) + " chains after " +
                         std::to_string(state.done) + " draws, does not fit the options or the parameters",
                     "a run continues with the options that it began with", "use the same options, or start anew");
}

}  // namespace

IssueList validate(const MetropolisOptions& options) {
  IssueList issues;
  const auto check = [&](bool right, const std::string& what, const std::string& why) {
    if (!right) issues.add({}, "Metropolis sampler: " + what, why, "use the default or a value in that range");
  };
  check(options.chains >= 1, std::to_string(options.chains) + " chains",
        "at least one; four tell whether they have met");
  check(options.draws >= 8, std::to_string(options.draws) + " draws", "at least 8 are needed for R-hat");
  check(options.warm_up >= 0, "negative warm_up", "a number of draws");
  check(options.block >= 1 && options.threads >= 1, "block or threads below 1", "at least one");
  check(options.acceptance > 0.0 && options.acceptance < 1.0, "acceptance out of range", "between 0 and 1");
  return issues;
}

MetropolisResult sample_metropolis(const Posterior& posterior, const MetropolisOptions& options,
                                   const MetropolisProgress& progress, const MetropolisState* from) {
  validate(options).raise();
  if (options.start) check_start(*options.start, posterior.prior);
  if (from) check_state(*from, posterior, options);
  MetropolisState state = from ? *from : begin(posterior, options);
  while (state.done < options.warm_up + options.draws) {
    advance(posterior, options, state);
    if (progress) progress(state);
  }
  return result_of(posterior, options, std::move(state));
}

}  // namespace kalfem
