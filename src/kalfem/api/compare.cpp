// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/compare.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "kalfem/api/inference_question.hpp"
#include "kalfem/inference/law_ranking.hpp"
#include "kalfem/statistics/mixture.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The options with the candidate's own unknowns behind the common ones, without what a comparison does not need.
InferOptions options_of(const CandidateStructure& candidate, const InferOptions& common) {
  InferOptions options = common;
  std::ranges::copy(candidate.unknowns, std::back_inserter(options.unknowns));
  std::ranges::copy(candidate.priors, std::back_inserter(options.priors));
  options.profile.clear();
  options.predictions = 0;
  return options;
}

void check(const std::vector<CandidateStructure>& candidates, const InferOptions& options, IssueList& issues) {
  if (candidates.size() < 2)
    issues.add({}, "candidates: " + std::to_string(candidates.size()) + " given", "a choice needs two",
               "add the structures that are possible");
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (candidates[i].name == candidates[j].name)
        issues.add({},
                   "candidates[" + std::to_string(i) + "] '" + candidates[i].name + "': candidates[" +
                       std::to_string(j) + "] has that name too",
                   "names tell them apart", "give each its own");
  if (options.likelihood != LikelihoodKind::filter)
    issues.add({}, "likelihood: structures are compared by that of the filter",
               "their evidence is that of the record, with the motion integrated out", "leave it out");
  if (options.method == PosteriorMethod::metropolis)
    issues.add({}, "method: metropolis gives no evidence", "", "take importance, tempered, laplace or filter");
}

/// The candidates' questions; all of them are about the same channels.
std::vector<InferenceQuestion> questions_of(const std::vector<CandidateStructure>& candidates, const Record& record,
                                            const InferOptions& options) {
  IssueList issues;
  check(candidates, options, issues);
  std::vector<InferenceQuestion> questions;
  for (std::size_t i = 0; i < candidates.size(); ++i) try {
      questions.push_back(make_inference_question(candidates[i].structure, record, options_of(candidates[i], options)));
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add({}, "candidates[" + std::to_string(i) + "] '" + candidates[i].name + "': " + issue.what, issue.why,
                   issue.fix);
    }
  issues.raise();
  return questions;
}

ComparedStructure compared(const RankedLaw& found) {
  return {.name = found.name,
          .probability = found.probability,
          .log_evidence = found.log_evidence,
          .log_evidence_std = found.log_evidence_deviation,
          .log_likelihood = found.log_likelihood,
          .occam = found.occam,
          .words = found.words,
          .parameters = posterior_parameters(found.units, found.prior, found.posterior, found.most_probable),
          .warnings = found.warnings,
          .failure = found.failure};
}

}  // namespace

std::vector<ComparedStructure> compare(const std::vector<CandidateStructure>& candidates, const Record& record,
                                       const InferOptions& options) {
  auto questions = questions_of(candidates, record, options);
  std::vector<LawCandidate> asked;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    asked.push_back({.name = candidates[i].name, .problem = std::move(questions[i].problem)});
  std::vector<ComparedStructure> all;
  for (const auto& law : rank_laws(asked, questions.front().record, options.progress)) all.push_back(compared(law));
  return all;
}

namespace {

bool is_in_all(const std::string& name, const std::vector<const EstimateResult*>& estimates) {
  return std::ranges::all_of(estimates, [&](const EstimateResult* estimate) {
    return std::ranges::find(estimate->outputs, name, &EstimatedQuantity::name) != estimate->outputs.end();
  });
}

void check_mixture(const std::vector<EstimateResult>& estimates) {
  IssueList issues;
  if (std::ranges::all_of(estimates, [](const auto& each) { return each.failure.has_value(); }))
    issues.add({}, "a mixture needs an estimate that ran to the end",
               estimates.empty() ? "none was given" : "all of them stopped");
  for (std::size_t i = 1; i < estimates.size(); ++i)
    if (estimates[i].nis.size() != estimates[0].nis.size())
      issues.add({}, "estimates[" + std::to_string(i) + "] has another number of samples than the first one",
                 "evidences of different records cannot be weighed", "estimate from one record");
  issues.raise();
}

}  // namespace

EstimateMixture mixture(const std::vector<EstimateResult>& estimates) {
  check_mixture(estimates);
  VectorXd evidences(std::ssize(estimates));
  for (Index i = 0; i < evidences.size(); ++i) {
    const auto& each = estimates[static_cast<std::size_t>(i)];
    evidences[i] = each.failure ? -std::numeric_limits<double>::infinity() : each.log_likelihood;
  }
  EstimateMixture mixed{weights_of(evidences), {}};
  std::vector<const EstimateResult*> weighty;
  std::vector<double> weights;
  for (Index i = 0; i < evidences.size(); ++i) {
    if (!(mixed.weights[i] > 0.0)) continue;
    weighty.push_back(&estimates[static_cast<std::size_t>(i)]);
    weights.push_back(mixed.weights[i]);
  }
  for (const auto& [name, unit, own_mean, own_std] : weighty.front()->outputs) {
    if (!is_in_all(name, weighty)) continue;
    std::vector<MixedModel> models;
    for (std::size_t i = 0; i < weighty.size(); ++i)
      models.push_back({weights[i], weighty[i]->output(name).mean, weighty[i]->output(name).std});
    auto [mean, deviation] = mixture_of(models);
    mixed.outputs.push_back({name, unit, std::move(mean), std::move(deviation)});
  }
  return mixed;
}

}  // namespace kalfem
