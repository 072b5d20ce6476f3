#include "kalfem/pipeline/run_identified_case.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The filter may have more unknowns behind those of the case: rest positions, which belong to this record.
std::vector<double> unknowns_of(const EstimationProblem& problem, const EstimationOutcome& estimation) {
  const VectorXd last = estimation.result.unknowns.mean.rightCols(1);
  const auto of_case = static_cast<Index>(problem.settings.unknowns.size());
  return {last.begin(), last.begin() + of_case};
}

}  // namespace

std::optional<IdentifiedCase> identified_case_of(const Study& study, const StudyResults& results) {
  if (!results.usable()) return std::nullopt;
  IdentifiedValues values;
  if (results.estimation) values.unknowns = unknowns_of(*study.problem, *results.estimation);
  if (results.updating) values.updated = {results.updating->values.begin(), results.updating->values.end()};
  if (values.unknowns.empty() && values.updated.empty()) return std::nullopt;
  return identified_case(study, values);
}

}  // namespace kalfem
