// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/tempered_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "kalfem/base/parallel.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/tempered_moves.hpp"

// A stage:
//   1. next_exponent(): bisection for the exponent at which the weights w_i = L_i^(beta' - beta) vary as asked;
//   2. relative_variance(): ln S = ln mean w, and its variance from sums over the samples of a common ancestor, which
//      are correlated if the moves of the stage before left them so;
//   3. resample(): multinomial, so that the variance of step 2 holds for the stages after it;
//   4. move_all(): every sample moves once per round. After a round the scale of the random walk follows the
//      acceptance, and rounds end when samples and their ancestors are no longer correlated. With a chain length above
//      one, the second and later samples of a chain start from the one before and take as many moves.
// Each sample draws from a stream of its own, so threads change nothing.

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

RandomStream stream(const TemperedOptions& options, std::size_t stage, const std::string& use,
                    Eigen::Index sample = 0) {
  return {options.seed, "tempered " + std::to_string(stage) + " " + use + " " + std::to_string(sample)};
}

double variation(const Eigen::VectorXd& log_weight) {
  const Eigen::ArrayXd weight = (log_weight.array() - log_weight.maxCoeff()).exp();
  const double mean = weight.mean();
  return std::sqrt((weight - mean).square().mean()) / mean;
}

/// (beta' - beta) ln L, also where L = 0 and the exponent stays.
Eigen::VectorXd log_weights(const Eigen::VectorXd& log_likelihood, double rise) {
  return log_likelihood.unaryExpr([&](double value) { return std::isfinite(value) ? rise * value : -infinity; });
}

/// Where the variation of the weights is as asked, or 1. The rise is found as a factor, since it may be 1e-8 of one.
/// Zero likelihoods vary the weights however small the rise: then these alone go.
double next_exponent(const TemperedState& state, double asked) {
  const double left = 1.0 - state.exponent;
  const auto varies = [&](double rise) { return variation(log_weights(state.log_likelihood, rise)); };
  if (varies(left) <= asked) return 1.0;
  double low = std::log(left) - 60.0, high = std::log(left);
  const double limit = std::max(asked, 1.05 * varies(std::exp(low)));
  if (varies(left) <= limit) return 1.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (varies(std::exp(middle)) <= limit ? low : high) = middle;
  }
  return state.exponent + std::exp(low);
}

/// Var(S) / S^2 = 1 / N^2 sum_a (sum of w_i / S - 1 over descendants i of a)^2, or without regard to ancestors,
/// whichever is larger.
double relative_variance(const Eigen::VectorXd& relative_weight, const Eigen::VectorXi& ancestor) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(relative_weight.size());
  for (Eigen::Index i = 0; i < relative_weight.size(); ++i) sums[ancestor[i]] += relative_weight[i] - 1.0;
  const double independent = (relative_weight.array() - 1.0).square().sum();
  const auto count = static_cast<double>(relative_weight.size());
  return std::max(sums.squaredNorm(), independent) / (count * count);
}

/// Var(Z) / Z^2 = 1 - (N / (N - 1))^n (1 - sum over origins of (sum of their descendants' weights)^2) after n
/// populations.
double lineage_variance(const Eigen::VectorXd& probability, const Eigen::VectorXi& origin, std::size_t populations) {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(probability.size());
  for (Eigen::Index i = 0; i < probability.size(); ++i) shares[origin[i]] += probability[i];
  const auto count = static_cast<double>(probability.size());
  return 1.0 - std::pow(count / (count - 1.0), static_cast<double>(populations)) * (1.0 - shares.squaredNorm());
}

/// Numbers of the samples drawn, in ascending order.
Eigen::VectorXi resample(const Eigen::VectorXd& probability, RandomStream random) {
  const Eigen::Index count = probability.size();
  std::vector<double> points(static_cast<std::size_t>(count));
  for (auto& point : points) point = random.uniform();
  std::sort(points.begin(), points.end());
  Eigen::VectorXi chosen(count);
  const double total = probability.sum();
  double reached = probability[0] / total;
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    while (k + 1 < count && (points[static_cast<std::size_t>(i)] >= reached || probability[k] == 0.0))
      reached += probability[++k] / total;
    chosen[i] = static_cast<int>(k);
  }
  for (Eigen::Index i = count; i-- > 0 && probability[chosen[i]] == 0.0;)  // rounding at the very end
    probability.maxCoeff(&chosen[i]);
  return chosen;
}

double correlation(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  const Eigen::ArrayXd x = a - a.mean(), y = b - b.mean();
  const double scale = std::sqrt(x.square().sum() * y.square().sum());
  return scale > 0.0 ? (x * y).sum() / scale : 0.0;
}

/// Largest correlation of any parameter, its square about the mean and the log-likelihood between two moments.
double correlation(const Population& before, const Population& now) {
  double largest = correlation(before.log_likelihood.array(), now.log_likelihood.array());
  for (Eigen::Index i = 0; i < now.z.rows(); ++i) {
    const Eigen::ArrayXd a = before.z.row(i).transpose(), b = now.z.row(i).transpose();
    largest = std::max({largest, correlation(a, b), correlation((a - a.mean()).square(), (b - b.mean()).square())});
  }
  return largest;
}

Population columns(const Population& population, const std::vector<Eigen::Index>& which) {
  return {population.z(Eigen::all, which), population.log_likelihood(which)};
}

/// Moves every layer of chains: samples that stand at the same place of their chains.
TemperedStage move_all(Population& now, const Eigen::VectorXi& ancestor, TemperedMover& mover,
                       const TemperedOptions& options, std::size_t stage) {
  TemperedStage report;
  std::vector<std::vector<Eigen::Index>> layers;
  for (Eigen::Index i = 0, place = 0; i < ancestor.size(); ++i) {
    place = i > 0 && ancestor[i] == ancestor[i - 1] ? (place + 1) % options.max_chain_length : 0;
    if (static_cast<std::size_t>(place) == layers.size()) layers.emplace_back();
    layers[static_cast<std::size_t>(place)].push_back(i);
  }
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    std::vector<Eigen::Index> from = layers[layer];
    if (layer > 0)
      for (auto& i : from) --i;  // the sample before in the same chain, which has moved
    const Population start = columns(now, from);
    Population moved = start;
    std::vector<RandomStream> random;
    for (const auto i : layers[layer]) random.push_back(stream(options, stage, "moves", i));
    for (int number = 0; layer == 0 || number < report.moves; ++number) {
      if (layer == 0 &&
          (number >= options.max_moves || (number >= options.min_moves && report.correlation < options.correlation)))
        break;
      mover.round(moved, random, number);
      if (layer > 0) continue;
      report.moves = number + 1;
      report.correlation = correlation(start, moved);
    }
    now.z(Eigen::all, layers[layer]) = moved.z;
    now.log_likelihood(layers[layer]) = moved.log_likelihood;
  }
  report.acceptance = mover.acceptance();
  return report;
}

}  // namespace

IssueList validate(const TemperedOptions& options) {
  IssueList issues;
  const auto check = [&](bool right, const std::string& what, const std::string& why) {
    if (!right) issues.add({}, "tempered sampler: " + what, why, "use the default or a value in that range");
  };
  check(options.samples >= 50, std::to_string(options.samples) + " samples", "at least 50 are needed");
  check(options.weight_variation > 0.0 && options.weight_variation <= 10.0, "weight_variation out of range", "0 to 10");
  check(options.max_chain_length >= 1, "max_chain_length below 1", "chains have at least one sample");
  check(options.acceptance > 0.0 && options.acceptance < 1.0, "acceptance out of range", "between 0 and 1");
  check(options.min_moves >= 1 && options.max_moves >= options.min_moves, "min_moves and max_moves out of range",
        "1 <= min_moves <= max_moves");
  check(options.correlation > 0.0, "correlation not positive", "moves would never end");
  check(options.max_stages >= 1 && options.threads >= 1, "max_stages or threads below 1", "at least one");
  return issues;
}

TemperedOptions tempered_options_for_expensive_likelihoods(int samples) {
  return {.samples = samples, .max_moves = 50, .correlation = 0.45};
}

double TemperedState::log_evidence() const {
  double sum = 0.0;
  for (const auto& stage : stages) sum += stage.log_evidence;
  return sum;
}

double TemperedState::log_evidence_deviation() const {
  double sum = 0.0;
  for (const auto& stage : stages) sum += stage.log_evidence_variance;
  return std::sqrt(std::max(sum, lineage_variance));
}

TemperedState begin_tempering(const Posterior& posterior, const TemperedOptions& options) {
  validate(options).raise();
  const Eigen::Index count = options.samples;
  TemperedState state;
  state.z.resize(posterior.prior.size(), count);
  state.log_likelihood.resize(count);
  state.ancestor = Eigen::VectorXi::LinSpaced(count, 0, static_cast<int>(count) - 1);
  state.origin = state.ancestor;
  state.scale = 0.5;
  state.evaluations = count;
  for_each_index(static_cast<std::size_t>(count), options.threads, [&](std::size_t k) {
    stop_if_asked();
    const auto i = static_cast<Eigen::Index>(k);
    RandomStream random = stream(options, 0, "prior", i);
    for (auto& value : state.z.col(i)) value = random.normal();
    state.log_likelihood[i] = posterior.log_likelihood_of(state.z.col(i));
  });
  if (!state.log_likelihood.array().isFinite().any())
    throw InvalidInput("none of " + std::to_string(count) + " samples of the prior has a likelihood",
                       "the model is impossible everywhere the prior allows", "check the model and the prior's bounds");
  return state;
}

void advance(const Posterior& posterior, const TemperedOptions& options, TemperedState& state) {
  const std::size_t number = state.stages.size() + 1;
  const double exponent = next_exponent(state, options.weight_variation);
  const Eigen::VectorXd log_weight = log_weights(state.log_likelihood, exponent - state.exponent);
  const auto count = static_cast<double>(log_weight.size());
  const double log_mean = log_sum_exp(log_weight) - std::log(count);
  const Eigen::VectorXd relative = (log_weight.array() - log_mean).exp();

  const Population archive{state.z, state.log_likelihood};
  const Eigen::VectorXd probability = relative / relative.sum();
  const Eigen::VectorXi ancestor = resample(probability, stream(options, number, "resampling"));
  Population now = columns(archive, std::vector<Eigen::Index>(ancestor.begin(), ancestor.end()));
  TemperedMover mover(posterior, options, exponent, archive, probability, state.scale);
  TemperedStage stage = move_all(now, ancestor, mover, options, number);
  stage.exponent = exponent;
  stage.log_evidence = log_mean;
  stage.log_evidence_variance = relative_variance(relative, state.ancestor);

  state.lineage_variance = lineage_variance(probability, state.origin, number);
  state.origin = Eigen::VectorXi(state.origin(ancestor));
  state.exponent = exponent;
  state.z = std::move(now.z);
  state.log_likelihood = std::move(now.log_likelihood);
  state.ancestor = ancestor;
  state.scale = mover.scale();
  state.evaluations += mover.evaluations();
  state.stages.push_back(stage);
}

TemperedResult sample_tempered(const Posterior& posterior, const TemperedOptions& options,
                               const TemperedProgress& progress, const TemperedState* from) {
  validate(options).raise();
  if (from && (from->z.cols() != options.samples || from->z.rows() != posterior.prior.size()))
    throw InvalidInput("the stored state has " + std::to_string(from->z.cols()) + " samples of " +
                           std::to_string(from->z.rows()) + " parameters, not " + std::to_string(options.samples) +
                           " of " + std::to_string(posterior.prior.size()),
                       "a run continues with the options that it began with", "use the same options, or start anew");
  TemperedState state = from ? *from : begin_tempering(posterior, options);
  if (!from && progress) progress(state);
  while (!state.finished() && static_cast<int>(state.stages.size()) < options.max_stages) {
    advance(posterior, options, state);
    if (progress) progress(state);
  }
  return {.samples = make_sample_set(posterior.prior, state.z, state.log_likelihood, 1),
          .log_evidence = state.log_evidence(),
          .log_evidence_deviation = state.log_evidence_deviation(),
          .state = state,
          .finished = state.finished()};
}

}  // namespace kalfem
