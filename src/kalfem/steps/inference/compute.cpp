// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/compute.hpp"

#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/own_information.hpp"
#include "kalfem/inference/infer.hpp"
#include "kalfem/inference/law_ranking.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/inference/comparisons_likelihood.hpp"
#include "kalfem/steps/inference/likelihood_checkpoint.hpp"

namespace kalfem {
namespace {

/// The samples of the record, or of the simulation that makes one, without channels where there are none yet.
Record time_of(const Study& study) {
  if (study.record) return study.record->record;
  Record time{.sample_rate = study.simulation->sample_rate};
  time.values.resize(0, std::llround(study.simulation->duration * time.sample_rate) + 1);
  return time;
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

LawCandidate candidate_of(const LawAlternative& alternative, LikelihoodCheckpoint& checkpoint) {
  const Study& study = *alternative.study;
  const InferenceProblem& problem = *study.inference;
  LawCandidate candidate{alternative.name, alternative.law, problem};
  if (study.validation)
    candidate.held_back = {held_back_problem(study), study.validation->record.record, study.validation->from_rest};
  candidate.remember = checkpoint.of(study);
  return candidate;
}

/// The laws of infer.compare_laws on the same record.
LawRanking ranking_of(const InferencePlan& plan, const Record& record, LikelihoodCheckpoint& checkpoint,
                      const Progress& progress) {
  LawRanking ranking;
  for (const auto& connector : plan.connectors)
    ranking.connector += (ranking.connector.empty() ? "" : ", ") + connector;
  std::vector<LawCandidate> candidates;
  for (const auto& alternative : plan.laws) candidates.push_back(candidate_of(alternative, checkpoint));
  ranking.laws = rank_laws(candidates, record, progress);
  return ranking;
}

}  // namespace

std::optional<Identifiability> identifiability_before(const Study& study) {
  if (study.inference->likelihood == LikelihoodKind::comparisons || !study.problem) return std::nullopt;
  return expected_identifiability(*study.inference, time_of(study));
}

std::optional<Identifiability> told_by_sensors(const Study& study) try {
  constexpr Eigen::Index most_samples = 4000;  // which tell what can be told apart at all
  if (!study.problem || study.problem->settings.local) return std::nullopt;
  IssueList unknown;
  check_excitation_is_known(*study.problem, unknown);
  if (!unknown.empty()) return std::nullopt;
  Record time = time_of(study);
  time.values.conservativeResize(time.values.rows(), std::min(time.values.cols(), most_samples));
  if (time.used) time.used = std::min(*time.used, time.samples());
  const auto own = own_information(study.problem, time);
  if (!own || !own->information.allFinite()) return std::nullopt;
  return identifiability(own->information, own->parameters);
} catch (const InvalidInput&) {
  return std::nullopt;  // nothing can be foreseen
}

InferenceOutcome run_inference(const Study& study, const StudyResults& results, const RunOptions& options) {
  const Stopwatch watch;
  const auto& plan = *study.inference;
  LikelihoodCheckpoint checkpoint(options.folder);
  const double share = plan.laws.empty() ? 1.0 : 1.0 / static_cast<double>(1 + plan.laws.size());
  const InferenceAids aids{results.find<EstimationOutcome>(), checkpoint.of(study),
                           part_of(options.progress, 0.0, share)};
  InferenceOutcome outcome = plan.likelihood == LikelihoodKind::comparisons
                                 ? infer(plan, likelihood_of_comparisons(study, results), aids)
                                 : infer(plan, record_of(study, results), aids);
  if (!plan.laws.empty())
    outcome.laws = ranking_of(plan, record_of(study, results), checkpoint, part_of(options.progress, share, 1.0));
  outcome.evaluations_before = checkpoint.from_earlier();
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
