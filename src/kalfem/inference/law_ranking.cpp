// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/law_ranking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/inference/predictive_bands.hpp"
#include "kalfem/inference/sample_posterior.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/importance_sampler.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index validation_draws = 50;

/// Root mean square about the mean, of the samples that are there, over all channels relative to their own: the mean of
/// the channels' ratios.
double mean_ratio(const Eigen::MatrixXd& errors, const Eigen::MatrixXd& measured) {
  double sum = 0.0;
  for (Index j = 0; j < measured.rows(); ++j) {
    const auto known = measured.row(j).array().isFinite() && errors.row(j).array().isFinite();
    const double count = std::max<double>(1.0, static_cast<double>(known.count()));
    const double mean = known.select(measured.row(j).array(), 0.0).sum() / count;
    const double size = known.select((measured.row(j).array() - mean).square(), 0.0).sum();
    sum += std::sqrt(known.select(errors.row(j).array().square(), 0.0).sum() / size);
  }
  return sum / static_cast<double>(measured.rows());
}

/// Whether the simulation of the part starts from a state that is known.
bool starts_known(const LawCandidate& candidate) {
  const auto& system = candidate.problem.setup.model->system();
  return candidate.held_back->from_rest || system.size() + system.connector_states() == 0;
}

/// How the posterior foresees the record that is held back: density of its samples, and the two errors at the
/// posterior's mean.
void validate(const LawCandidate& candidate, const InferenceResult& result, RankedLaw& law) {
  const auto& [problem, record, from_rest] = *candidate.held_back;
  const auto names = names_of(candidate.problem);
  const VectorXd mean = result.centre();
  const FilterLikelihood likelihood(problem, record, names, {.first = mean});
  const auto draws = resample(result.samples, validation_draws, candidate.problem.seed);
  VectorXd densities(draws.values.cols());
  for_each_index(static_cast<std::size_t>(densities.size()), candidate.problem.threads(), [&](std::size_t k) {
    densities[static_cast<Index>(k)] = likelihood.log_likelihood(draws.values.col(static_cast<Index>(k)));
  });
  law.validation = (log_sum_exp(densities) - std::log(static_cast<double>(densities.size()))) /
                   static_cast<double>(record.samples_used());
  std::vector<std::string> sensors;
  for (const auto& sensor : problem->sensors)
    if (record.find(sensor.name) >= 0) sensors.push_back(sensor.name);
  const Record compared = select_channels(record, sensors);
  if (const auto innovations = likelihood.innovations(mean))
    law.validation_one_step = mean_ratio(innovations->value, compared.values.leftCols(innovations->value.cols()));
  if (!starts_known(candidate) || !can_be_simulated(candidate.problem)) return;
  if (const auto simulated = expected_record(problem, record, names, mean))
    law.validation_open_loop =
        mean_ratio(select_channels(*simulated, sensors).values - compared.values, compared.values);
}

RankedLaw evaluate(const LawCandidate& candidate, const Record& record, const Progress& progress) try {
  const auto& problem = candidate.problem;
  RankedLaw law{.name = candidate.name, .law = candidate.law, .parameters = std::ssize(problem.parameters)};
  const RecordEstimate estimate = estimate_record(problem.problem, problem.setup, record);
  InferenceResult result;
  posterior_of_record(problem, record, {&estimate, candidate.remember, progress}, result);
  law.warnings = result.warnings;
  if (!result.log_evidence) {
    law.failure = "its method gives no evidence";
    return law;
  }
  law.log_evidence = *result.log_evidence;
  law.log_evidence_deviation = result.log_evidence_deviation.value_or(0.0);
  law.log_likelihood = std::max(result.log_likelihood, result.samples.log_likelihood.maxCoeff());
  law.occam = law.log_evidence - law.log_likelihood;
  law.prior = summarise_prior(problem.prior);
  law.posterior = result.posterior;
  law.most_probable = result.most_probable;
  for (const auto& parameter : problem.parameters) law.units.push_back(parameter.unit);
  if (candidate.held_back) validate(candidate, result, law);
  return law;
} catch (const InvalidInput& error) {
  return {.name = candidate.name, .law = candidate.law, .failure = error.issues().front().what};
}

/// Sorts by the evidence, and gives each its probability and the best one's words against it.
void weigh(std::vector<RankedLaw>& laws) {
  std::ranges::stable_sort(laws, [](const RankedLaw& one, const RankedLaw& other) {
    if (one.failure.empty() != other.failure.empty()) return one.failure.empty();
    return one.log_evidence > other.log_evidence;
  });
  VectorXd evidence(std::ssize(laws));
  for (std::size_t i = 0; i < laws.size(); ++i)
    evidence[static_cast<Index>(i)] =
        laws[i].failure.empty() ? laws[i].log_evidence : -std::numeric_limits<double>::infinity();
  if (!std::isfinite(evidence.maxCoeff())) return;
  const VectorXd probabilities = model_probabilities(evidence);
  for (std::size_t i = 0; i < laws.size(); ++i) {
    laws[i].probability = probabilities[static_cast<Index>(i)];
    if (i > 0 && laws[i].failure.empty())
      laws[i].words = kass_raftery(laws.front().log_evidence - laws[i].log_evidence);
  }
}

}  // namespace

std::vector<RankedLaw> rank_laws(const std::vector<LawCandidate>& candidates, const Record& record,
                                 const Progress& progress) {
  std::vector<RankedLaw> laws;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto of_all = [&, i](std::string_view, double fraction) {
      if (progress)
        progress("law " + std::to_string(i + 1) + " of " + std::to_string(candidates.size()),
                 (static_cast<double>(i) + fraction) / static_cast<double>(candidates.size()));
    };
    laws.push_back(evaluate(candidates[i], record, of_all));
  }
  weigh(laws);
  return laws;
}

}  // namespace kalfem
