// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/fixed_number_reasons.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/judge.hpp"
#include "kalfem/steps/updating/outcome.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The filter may have more unknowns behind those of the structure: offsets of sensors.
std::vector<double> unknowns_of(const EstimationProblem& problem, const EstimationOutcome& estimation) {
  const VectorXd last = estimation.result.unknowns.mean.rightCols(1);
  const auto of_case = static_cast<Index>(problem.settings.unknowns.size());
  return {last.begin(), last.begin() + of_case};
}

/// Offsets of sensors, and what was found by maximum likelihood.
std::vector<std::pair<std::string, double>> of_measurement(const EstimationProblem& problem,
                                                           const EstimationOutcome& estimation) {
  std::vector<std::pair<std::string, double>> values;
  const auto& unknowns = estimation.augmented_model->options().unknowns;
  for (const auto& offset : problem.offsets) {
    const auto found = std::ranges::find(unknowns, offset.name, &UnknownParameter::name);
    if (found != unknowns.end() && !is_rest_position(offset))
      values.emplace_back(offset.name, estimation.result.unknowns.mean(found - unknowns.begin(), Eigen::last));
  }
  if (!estimation.likelihood) return values;
  for (std::size_t i = 0; i < estimation.likelihood->unknowns.size(); ++i)
    values.emplace_back(estimation.likelihood->unknowns[i].name, estimation.likelihood->values[static_cast<Index>(i)]);
  return values;
}

/// Stated numbers where the estimates stand.
void put_moved(const FixedNumberStudy& study, IdentifiedValues& values) {
  for (Index i = 0; i < study.size(); ++i) {
    const auto& number = study.numbers[static_cast<std::size_t>(i)];
    const double change = study.stands_at[i];
    if (change == 0.0) continue;
    if (number.parameter)
      values.moved.emplace_back(*number.parameter, number.value + change * number.scale);
    else
      values.moved_signals.push_back("'" + number.name + "' " + change_in_words(number, change));
  }
}

}  // namespace

std::optional<IdentifiedCase> identified_case_of(const Study& study, const StudyResults& results) {
  if (!results.usable()) return std::nullopt;
  IdentifiedValues values;
  if (const auto* estimation = results.find<EstimationOutcome>()) {
    values.unknowns = unknowns_of(*study.problem, *estimation);
    values.of_measurement = of_measurement(*study.problem, *estimation);
    if (estimation->fixed_numbers) put_moved(*estimation->fixed_numbers, values);
  }
  if (const auto* updating = results.find<UpdatingOutcome>())
    values.updated = {updating->values.begin(), updating->values.end()};
  if (values.unknowns.empty() && values.updated.empty() && values.of_measurement.empty()) return std::nullopt;
  return identified_case(study, values);
}

}  // namespace kalfem
