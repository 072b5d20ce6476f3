// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/importance_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/pareto_smoothing.hpp"
#include "kalfem/sampling/peak_search.hpp"
#include "kalfem/sampling/student_mixture.hpp"

// 1. find_peaks() over z, and laplace_about() each: the eigenvalues of -H below one, where the likelihood is not curved
//    downwards, count as one, the prior's own curvature.
// 2. draw_rounds(): N / 4, N / 4 and N / 2 samples, each from a random stream of its own.
// 3. Between rounds, if few samples are effective, fit_anew(): one step of expectation and maximisation over the
//    weighted samples. These are then discarded, since they have drawn the fit towards themselves.
// 4. modes_of() the samples, each of which belongs to the parts by their shares of the proposal there.

namespace kalfem {
namespace {

constexpr double enough_samples = 100.0;  ///< effective ones

/// A part of the posterior: one t distribution of the proposal.
struct Part {
  double share = 1.0;
  NormalApproximation scale;
  bool at_maximum = true;  ///< the search converged
};

/// Steps of the differences are at most 0.15, over which the prior alone falls by 0.01.
NormalApproximation laplace_about(const Peak& peak, const LogDensity& log_density) {
  const Eigen::VectorXd reach = Eigen::VectorXd::Constant(peak.z.size(), 0.3);  // twice the longest step
  const Eigen::VectorXd first_steps = 0.1 * peak.inverse.diagonal().cwiseSqrt();
  Eigen::MatrixXd hessian =
      LocalDifferences(log_density, peak.z, first_steps, peak.z - reach, peak.z + reach).hessian();
  if (!hessian.allFinite()) hessian = -peak.inverse.inverse();  // beside an impossible model
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> curvature(-hessian);
  const Eigen::VectorXd variance = curvature.eigenvalues().cwiseMax(1.0).cwiseInverse();
  return {peak.z, curvature.eigenvectors() * variance.asDiagonal() * curvature.eigenvectors().transpose()};
}

/// Shares by Z of each Laplace approximation, a tenth of them equal.
std::vector<Part> parts_about(const std::vector<Peak>& peaks, const LogDensity& log_density) {
  const auto count = static_cast<Eigen::Index>(peaks.size());
  std::vector<Part> parts;
  Eigen::VectorXd log_mass(count);
  for (Eigen::Index d = 0; d < count; ++d) {
    const Peak& peak = peaks[static_cast<std::size_t>(d)];
    parts.push_back({1.0, laplace_about(peak, log_density), peak.converged});
    const Eigen::LLT<Eigen::MatrixXd> factor(parts.back().scale.covariance);
    log_mass[d] = peak.value + factor.matrixLLT().diagonal().array().log().sum();
  }
  for (Eigen::Index d = 0; d < count; ++d)
    parts[static_cast<std::size_t>(d)].share =
        0.1 / static_cast<double>(count) + 0.9 * std::exp(log_mass[d] - log_sum_exp(log_mass));
  return parts;
}

/// The prior's share of the prior, and `parts` for the rest, of which a quarter remains with `guard` if these are
/// given.
StudentMixture proposal_of(const std::vector<Part>& parts, const std::vector<Part>& guard,
                           const ImportanceOptions& options) {
  StudentMixture mixture;
  const double rest = 1.0 - options.prior_share;
  const auto add = [&](const std::vector<Part>& added, double share) {
    for (const auto& part : added) {
      mixture.components.emplace_back(part.scale, options.degrees);
      mixture.shares.push_back(share * part.share);
    }
  };
  add(parts, guard.empty() ? rest : 0.75 * rest);
  add(guard, 0.25 * rest);
  if (options.prior_share == 0.0) return mixture;
  const auto size = parts.front().scale.mean.size();
  const NormalApproximation prior{Eigen::VectorXd::Zero(size), Eigen::MatrixXd::Identity(size, size)};
  mixture.components.emplace_back(prior, 0);
  mixture.shares.push_back(options.prior_share);
  return mixture;
}

/// Samples of one proposal.
struct Draws {
  Eigen::MatrixXd z;
  Eigen::VectorXd log_likelihood;
  Eigen::VectorXd log_weight;  ///< ln f - ln q
};

double log_normal_density(const Eigen::VectorXd& z) {
  return -0.5 * z.squaredNorm() - 0.5 * static_cast<double>(z.size()) * std::log(2.0 * std::numbers::pi);
}

/// Adds samples number `first` to `last` - 1 of the run, evaluated side by side in blocks, between which the progress
/// is reported.
void add_draws(Draws& draws, const StudentMixture& proposal, Eigen::Index first, Eigen::Index last,
               const Posterior& posterior, const ImportanceOptions& options, const Progress& progress) {
  const Eigen::Index before = draws.z.cols(), size = last - first;
  draws.z.conservativeResize(posterior.prior.size(), before + size);
  draws.log_likelihood.conservativeResize(before + size);
  draws.log_weight.conservativeResize(before + size);
  const double offset = RandomStream(options.seed, "importance round " + std::to_string(first)).uniform();
  const Eigen::Index block = std::max(16, 4 * options.threads);
  for (Eigen::Index begin = first; begin < last; begin += block) {
    if (progress) progress("samples", static_cast<double>(begin) / options.samples);
    for_each_index(static_cast<std::size_t>(std::min(block, last - begin)), options.threads, [&](std::size_t k) {
      stop_if_asked();
      const Eigen::Index number = begin + static_cast<Eigen::Index>(k), i = before + number - first;
      RandomStream random(options.seed, "importance sample " + std::to_string(number));
      const double place = (static_cast<double>(number - first) + offset) / static_cast<double>(size);
      const Eigen::VectorXd z = proposal.draw(place, random);
      draws.z.col(i) = z;
      draws.log_likelihood[i] = posterior.log_likelihood_of(z);
      draws.log_weight[i] = draws.log_likelihood[i] + log_normal_density(z) - proposal.log_density(z);
    });
  }
}

Eigen::VectorXd normalised(const Eigen::VectorXd& log_weight) {
  const Eigen::VectorXd weight = (log_weight.array() - log_weight.maxCoeff()).exp();
  return weight / weight.sum();
}

double effective(const Eigen::VectorXd& weight) { return 1.0 / weight.squaredNorm(); }

NormalApproximation moments(const Eigen::MatrixXd& z, const Eigen::VectorXd& weight) {
  const Eigen::VectorXd mean = z * weight;
  const Eigen::MatrixXd centred = z.colwise() - mean;
  return {mean, centred * weight.asDiagonal() * centred.transpose()};
}

/// Weights of the samples, samples x parts: a sample belongs to a part by that part's share of the density there.
Eigen::MatrixXd weights_of(const std::vector<Part>& parts, const Draws& draws, const Eigen::VectorXd& weight,
                           int degrees) {
  const auto count = static_cast<Eigen::Index>(parts.size());
  Eigen::MatrixXd belongs(draws.z.cols(), count);
  for (Eigen::Index d = 0; d < count; ++d) {
    const Part& part = parts[static_cast<std::size_t>(d)];
    const StudentDistribution about(part.scale, degrees);
    for (Eigen::Index i = 0; i < draws.z.cols(); ++i)
      belongs(i, d) = std::log(part.share) + about.log_density(draws.z.col(i));
  }
  for (Eigen::Index i = 0; i < draws.z.cols(); ++i)
    belongs.row(i) = weight[i] * normalised(belongs.row(i).transpose()).transpose();
  return belongs;
}

/// Shares, means and covariances of the parts from the weighted samples. The part as it was counts like two effective
/// samples for each parameter.
std::vector<Part> fit_anew(const std::vector<Part>& parts, const Draws& draws, const Eigen::VectorXd& weight,
                           const ImportanceOptions& options) {
  const auto count = static_cast<Eigen::Index>(parts.size());
  const Eigen::MatrixXd belongs = weights_of(parts, draws, weight, options.degrees);
  std::vector<Part> fitted = parts;
  for (Eigen::Index d = 0; d < count; ++d) {
    Part& part = fitted[static_cast<std::size_t>(d)];
    const double mass = belongs.col(d).sum();
    part.share = 0.1 / static_cast<double>(count) + 0.9 * mass;
    if (!(mass > 0.0)) continue;
    const Eigen::VectorXd own = belongs.col(d) / mass;
    const double known = effective(own), before = 2.0 * static_cast<double>(draws.z.rows());
    const NormalApproximation found = moments(draws.z, own);
    part.scale.mean = (known * found.mean + before * part.scale.mean) / (known + before);
    part.scale.covariance = (known * found.covariance + before * part.scale.covariance) / (known + before);
  }
  return fitted;
}

std::vector<std::string> warnings_of(const ImportanceResult& result, bool converged) {
  std::vector<std::string> warnings;
  const std::string remedy = "; take more samples, or sample_tempered";
  const double limit = k_hat_limit(result.samples.values.cols());
  if (!(result.k_hat < limit))
    warnings.push_back("k-hat of the weights is " + shortest(std::round(100.0 * result.k_hat) / 100.0) +
                       ", not below " + shortest(std::round(100.0 * limit) / 100.0) +
                       ": the posterior has parts that the proposal hardly reaches" + remedy);
  if (result.effective_samples < enough_samples)
    warnings.push_back("the weighted samples are worth " + shortest(std::round(result.effective_samples)) +
                       " independent ones, fewer than 100" + remedy);
  if (!converged && !warnings.empty())
    warnings.emplace_back("the search for the maximum did not converge; try another start or more iterations");
  return warnings;
}

ImportanceResult result_of(const Posterior& posterior, const Draws& draws) {
  ImportanceResult result;
  const SmoothedWeights smoothed = smooth_weights(draws.log_weight);
  const auto count = static_cast<double>(draws.z.cols());
  result.k_hat = smoothed.k_hat;
  result.log_evidence = log_sum_exp(smoothed.log_weights) - std::log(count);
  if (!std::isfinite(result.log_evidence))
    throw InvalidInput("none of " + shortest(count) + " samples about the maximum has a likelihood",
                       "the model is impossible nearly everywhere", "check the model and the prior's bounds");
  result.samples = make_sample_set(posterior.prior, draws.z, draws.log_likelihood, 1);
  result.samples.weights = normalised(smoothed.log_weights);
  result.effective_samples = effective(result.samples.weights);
  result.log_evidence_deviation = std::sqrt(std::max(0.0, 1.0 / result.effective_samples - 1.0 / count));
  result.approximation = moments(draws.z, result.samples.weights);
  return result;
}

/// The posterior about each maximum, by the weighted samples.
std::vector<PosteriorMode> modes_of(const std::vector<Part>& about_peaks, const std::vector<Part>& fitted,
                                    const Draws& draws, const ImportanceResult& result, const Posterior& posterior,
                                    int degrees) {
  std::vector<Part> parts;
  std::vector<Eigen::VectorXd> peaks;
  for (std::size_t d = 0; d < fitted.size(); ++d) {
    if (!fitted[d].at_maximum) continue;
    parts.push_back(fitted[d]);
    peaks.push_back(posterior.prior.from_standard_normal(about_peaks[d].scale.mean));
  }
  if (parts.empty()) return {};
  const Eigen::MatrixXd belongs = weights_of(parts, draws, result.samples.weights, degrees);
  std::vector<PosteriorMode> modes;
  for (std::size_t d = 0; d < parts.size(); ++d) {
    const Eigen::VectorXd own = belongs.col(static_cast<Eigen::Index>(d));
    if (own.sum() < least_mode_weight) continue;
    const auto [mean, covariance] = moments(result.samples.values, own / own.sum());
    modes.push_back({own.sum(), peaks[d], mean, covariance.diagonal().cwiseMax(0.0).cwiseSqrt()});
  }
  return told_apart(std::move(modes));
}

/// The samples since the proposal was last fitted, and the `parts` that proposed them.
Draws draw_rounds(const std::vector<Part>& about_peaks, const Posterior& posterior, const ImportanceOptions& options,
                  const Progress& progress, std::vector<Part>& parts) {
  parts = about_peaks;
  StudentMixture proposal = proposal_of(parts, {}, options);
  Draws draws;
  const Eigen::Index samples = options.samples;
  const std::array<Eigen::Index, 4> ends = {0, samples / 4, samples / 2, samples};
  for (std::size_t round = 0; round < 3; ++round) {
    if (round > 0 && draws.log_weight.array().isFinite().any()) {
      const Eigen::VectorXd weight = normalised(smooth_weights(draws.log_weight).log_weights);
      if (effective(weight) < options.efficiency * static_cast<double>(weight.size())) {
        parts = fit_anew(parts, draws, weight, options);
        proposal = proposal_of(parts, about_peaks, options);
        draws = {};
      }
    }
    add_draws(draws, proposal, ends[round], ends[round + 1], posterior, options, progress);
  }
  return draws;
}

}  // namespace

bool ImportanceResult::reliable() const {
  return k_hat < k_hat_limit(samples.values.cols()) && effective_samples >= enough_samples;
}

IssueList validate(const ImportanceOptions& options) {
  IssueList issues;
  const auto check = [&](bool right, const std::string& what, const std::string& why) {
    if (!right) issues.add({}, "importance sampler: " + what, why, "use the default or a value in that range");
  };
  check(options.samples >= 100, std::to_string(options.samples) + " samples", "at least 100 are needed");
  check(options.degrees >= 1, std::to_string(options.degrees) + " degrees", "at least one; few make wide tails");
  check(options.prior_share >= 0.0 && options.prior_share < 1.0, "prior_share out of range", "at least 0, below 1");
  check(options.efficiency >= 0.0 && options.efficiency <= 1.0, "efficiency out of range", "0 to 1");
  check(options.max_iterations >= 1 && options.threads >= 1, "max_iterations or threads below 1", "at least one");
  check(options.random_starts >= 0 && options.search_likelihoods >= 0, "negative random_starts or search_likelihoods",
        "numbers of searches and of likelihoods");
  check(options.decrement > 0.0, "decrement not positive", "the search would never end");
  return issues;
}

ImportanceResult sample_importance(const Posterior& posterior, const ImportanceOptions& options,
                                   const Progress& progress) {
  validate(options).raise();
  if (progress) progress("maximum", 0.0);
  LogPosterior log_posterior(posterior, options.threads);
  const auto log_density = [&](const Eigen::MatrixXd& z) { return log_posterior.over_normals(z); };
  const auto [peaks, prior_starts] = find_peaks(log_density, posterior.prior,
                                                {.max_iterations = options.max_iterations,
                                                 .decrement = options.decrement,
                                                 .random_starts = options.random_starts,
                                                 .search_likelihoods = options.search_likelihoods,
                                                 .seed = options.seed,
                                                 .start = options.start});
  const std::vector<Part> about_peaks = parts_about(peaks, log_density);
  std::vector<Part> parts;
  const Draws draws = draw_rounds(about_peaks, posterior, options, progress, parts);
  ImportanceResult result = result_of(posterior, draws);
  result.modes = modes_of(about_peaks, parts, draws, result, posterior, options.degrees);
  result.prior_starts = prior_starts;
  result.evaluations = log_posterior.evaluations() + options.samples;
  result.warnings = warnings_of(result, peaks.front().converged);
  if (progress) progress("samples", 1.0);
  return result;
}

}  // namespace kalfem
