// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "kalfem/statistics/mixture.hpp"
#include "kalfem/steps/updating/compute.hpp"

namespace kalfem {

using Eigen::VectorXd;

Study with_alternative(const Study& study, const AlternativeUpdating& alternative) {
  Study other = study;
  other.updating = alternative.setup;
  other.updating_plan = alternative.plan;
  return other;
}

void run_alternatives(const Study& study, const StudyResults& results, UpdatingOutcome& outcome) {
  const auto& plans = study.updating_plan->alternatives;
  if (plans.empty() || !outcome.log_evidence) return;
  std::vector<double> evidences{*outcome.log_evidence};
  for (const auto& plan : plans) {
    AlternativeOutcome found{plan, {}, {}};
    found.outcome = run_updating(with_alternative(study, *plan), results, {}, found.failure);
    evidences.push_back(found.failure.empty() ? *found.outcome.log_evidence : -std::numeric_limits<double>::infinity());
    outcome.alternatives.push_back(std::move(found));
  }
  const VectorXd weights = weights_of(VectorXd::Map(evidences.data(), std::ssize(evidences)));
  outcome.weight = weights[0];
  for (std::size_t i = 0; i < outcome.alternatives.size(); ++i)
    outcome.alternatives[i].outcome.weight = weights[static_cast<Eigen::Index>(i) + 1];
}

}  // namespace kalfem
