// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/compute.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/steps/inference/case_likelihood.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/posterior.hpp"
#include "kalfem/study/study.hpp"

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

/// The problem over the validation part.
EstimationProblemPtr held_back_problem(const Study& study) {
  auto structure = std::make_shared<StructureModel>(*study.problem->structure);
  structure->signals = study.validation->signals;
  auto problem = std::make_shared<EstimationProblem>(*study.problem);
  problem->structure = std::move(structure);
  problem->sample_rate = study.validation->record.record.sample_rate;
  return problem;
}

/// Whether the simulation of the part starts from a state that is known.
bool starts_known(const Study& study) {
  const auto& system = study.model->system();
  return study.validation->from_rest || system.size() + system.connector_states() == 0;
}

/// How the posterior foresees the validation part: density of its samples, and the two errors at the posterior's mean.
void validate(const Study& study, const InferenceOutcome& outcome, int threads, RankedLaw& law) {
  const auto problem = held_back_problem(study);
  const auto names = names_of(*study.inference);
  const Record& record = study.validation->record.record;
  const VectorXd mean = outcome.centre();
  const FilterLikelihood likelihood(problem, record, names, {.first = mean});
  const auto draws = resample(outcome.samples, validation_draws, study.inference->seed);
  VectorXd densities(draws.values.cols());
  for_each_index(static_cast<std::size_t>(densities.size()), threads, [&](std::size_t k) {
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
  if (!starts_known(study) || !can_be_simulated(study)) return;
  if (const auto simulated = expected_record(problem, record, names, mean))
    law.validation_open_loop =
        mean_ratio(select_channels(*simulated, sensors).values - compared.values, compared.values);
}

RankedLaw evaluate(const LawAlternative& alternative, const Record& record, LikelihoodCheckpoint& checkpoint,
                   const Progress& progress) try {
  const Study& study = *alternative.study;
  const auto& plan = *study.inference;
  const int threads = filter_threads(study.problem->settings);
  RankedLaw law{.name = alternative.name, .law = alternative.law, .parameters = std::ssize(plan.parameters)};
  const RecordEstimate estimate = estimate_record(study.problem, *study.augmented_model, record);
  InferenceOutcome outcome;
  posterior_of_record(study, record, &estimate, checkpoint, progress, outcome);
  law.warnings = outcome.warnings;
  if (!outcome.log_evidence) {
    law.failure = "its method gives no evidence";
    return law;
  }
  law.log_evidence = *outcome.log_evidence;
  law.log_evidence_deviation = outcome.log_evidence_deviation.value_or(0.0);
  law.log_likelihood = std::max(outcome.log_likelihood, outcome.samples.log_likelihood.maxCoeff());
  law.occam = law.log_evidence - law.log_likelihood;
  law.posterior = outcome.posterior;
  for (const auto& parameter : plan.parameters) law.units.push_back(parameter.unit);
  if (study.validation) validate(study, outcome, threads, law);
  return law;
} catch (const InvalidInput& error) {
  return {.name = alternative.name, .law = alternative.law, .failure = error.issues().front().what};
}

}  // namespace

LawRanking rank_laws(const Study& study, const Record& record, LikelihoodCheckpoint& checkpoint,
                     const Progress& progress) {
  const auto& alternatives = study.inference->laws;
  LawRanking ranking;
  for (const auto& connector : study.inference->connectors)
    ranking.connector += (ranking.connector.empty() ? "" : ", ") + connector;
  for (std::size_t i = 0; i < alternatives.size(); ++i) {
    const auto of_all = [&, i](std::string_view, double fraction) {
      if (progress)
        progress("law " + std::to_string(i + 1) + " of " + std::to_string(alternatives.size()),
                 (static_cast<double>(i) + fraction) / static_cast<double>(alternatives.size()));
    };
    ranking.laws.push_back(evaluate(alternatives[i], record, checkpoint, of_all));
  }
  std::ranges::stable_sort(ranking.laws, [](const RankedLaw& one, const RankedLaw& other) {
    if (one.failure.empty() != other.failure.empty()) return one.failure.empty();
    return one.log_evidence > other.log_evidence;
  });
  VectorXd evidence(std::ssize(ranking.laws));
  for (std::size_t i = 0; i < ranking.laws.size(); ++i)
    evidence[static_cast<Index>(i)] =
        ranking.laws[i].failure.empty() ? ranking.laws[i].log_evidence : -std::numeric_limits<double>::infinity();
  if (!std::isfinite(evidence.maxCoeff())) return ranking;
  const VectorXd probabilities = model_probabilities(evidence);
  for (std::size_t i = 0; i < ranking.laws.size(); ++i) {
    auto& law = ranking.laws[i];
    law.probability = probabilities[static_cast<Index>(i)];
    if (i > 0 && law.failure.empty()) law.words = kass_raftery(ranking.laws.front().log_evidence - law.log_evidence);
  }
  return ranking;
}

}  // namespace kalfem
