// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/update.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/api/refined_parameters.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/api/update_comparisons.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/diagnosis/judge_updating.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/identification/stated_in_updating.hpp"
#include "kalfem/updating/first_information.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/parameter_interval.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double rms_of(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(std::max<Index>(1, values.size())));
}

/// Rows of each comparison in the weighted sum.
std::vector<ResidualBlock> blocks_of(const std::vector<MadeComparison>& comparisons) {
  std::vector<ResidualBlock> blocks;
  Index first = 0;
  for (const auto& each : comparisons) {
    const auto& residual = *each.continuation.back();
    blocks.push_back({each.name, first, residual.size(), residual.layout()});
    first += residual.size();
  }
  return blocks;
}

/// From wide to no smoothing, each search from the end of the one before.
LeastSquaresOutcome search(const std::vector<MadeComparison>& comparisons,
                           const std::vector<UpdatingParameter>& parameters, const UpdateOptions& given) {
  std::size_t steps = 1;
  for (const auto& each : comparisons) steps = std::max(steps, each.continuation.size());
  LeastSquaresOptions options{
      .search = {.max_evaluations = given.max_evaluations, .step_tolerance = given.tolerance, .cost_floor = 1e-6},
      .start = initial_values(parameters)};
  for (std::size_t step = 0; step + 1 < steps; ++step)
    options.start = minimise(sum_of(comparisons, step), parameters, options).parameters;
  return minimise(sum_of(comparisons, steps - 1), parameters, options);
}

/// What the comparisons tell before the updating.
UpdateResult::Before before_updating(const std::vector<MadeComparison>& comparisons,
                                     const std::vector<UpdatingParameter>& parameters, const ResidualValue& first) {
  std::vector<ComparedResidual> compared;
  for (const auto& each : comparisons) compared.push_back({each.name, each.continuation.back(), each.weight});
  const FirstInformation found = first_information(parameters, first, compared);
  UpdateResult::Before before{.undetermined = found.remarks};
  const auto names_of = [&](const std::vector<Index>& members) {
    std::vector<std::string> names;
    for (const Index i : members) names.push_back(parameters[static_cast<std::size_t>(i)].name);
    return names;
  };
  for (const auto& group : found.proposal.groups) before.groups.push_back(names_of(group));
  before.hold = names_of(found.proposal.hold);
  Index modes = 0;
  for (const auto& each : found.frequencies) modes += each.relative.rows();
  before.sensitivities.resize(modes, std::ssize(parameters));
  Index row = 0;
  for (const auto& each : found.frequencies) {
    before.sensitivities.middleRows(row, each.relative.rows()) = each.relative;
    row += each.relative.rows();
  }
  return before;
}

/// Rms of each comparison, without its weight, and the frequencies of its modes.
std::vector<EndOfComparison> compare(const std::vector<MadeComparison>& comparisons, const VectorXd& start,
                                     const VectorXd& before, const VectorXd& end, const VectorXd& after,
                                     UpdateResult& result) {
  std::vector<EndOfComparison> ends;
  Index row = 0;
  for (const auto& each : comparisons) {
    const Index size = each.continuation.back()->size();
    const auto rms = [&](const VectorXd& all) { return rms_of(all.segment(row, size)) / std::sqrt(each.weight); };
    result.comparisons.push_back({each.name, size, rms(before), rms(after)});
    ends.push_back(
        {.name = each.name, .size = size, .rms = rms(after), .has_bounds = has_bounds(*each.continuation.back())});
    row += size;
    const auto* modal = dynamic_cast<const ModalResidual*>(each.continuation.back().get());
    if (!modal) continue;
    const auto first = modal->compare(start).pairs;
    ends.back().modes = modal->compare(end).pairs;
    for (std::size_t i = 0; i < first.size(); ++i)
      result.frequencies.push_back(
          {first[i].measured_frequency, first[i].model_frequency, ends.back().modes[i].model_frequency});
  }
  return ends;
}

bool compares_a_record(const UpdateOptions& options) {
  return std::ranges::any_of(options.comparisons, [](const UpdateComparison& each) {
    return std::holds_alternative<MeasuredRecord>(each.what);
  });
}

/// The fixed numbers of which the options say something. Throws InvalidInput with everything that does not fit.
std::vector<FixedNumber> stated_of(const StructureModel& model, const std::vector<MadeComparison>& comparisons,
                                   const UpdateOptions& options) {
  if (options.known_to.empty()) return {};
  std::vector<ComparedGain> gains;
  for (const auto& each : comparisons)
    for (const auto& gain : each.continuation.back()->gains())
      if (std::ranges::find(gains, gain) == gains.end()) gains.push_back(gain);
  const auto names = names_of_parameters(options);
  const std::set<std::string> refined(names.begin(), names.end());
  const auto all = held_in_updating(model, refined, gains, compares_a_record(options));
  IssueList issues;
  check_known_to(options.known_to, all, refined, issues);
  issues.raise();
  return stated_numbers(all, options.known_to);
}

/// What is stated of fixed numbers, at the end of a search. Nothing where nothing is stated, or it found nothing.
std::optional<Considered> considered_at_end(const Structure& structure, const StructurePtr& model,
                                            const Refined& refined, const std::vector<FixedNumber>& stated,
                                            const LeastSquaresOutcome& outcome, const UpdateOptions& options) {
  if (stated.empty() || outcome.residual.jacobian.size() == 0) return std::nullopt;
  const auto wide = with_numbers({refined.parameters, refined.bindings, {}}, stated);
  const auto connectors = connectors_of(wide.bindings);
  const auto comparisons = make_comparisons(
      structure, model,
      std::make_shared<const ParameterisedStructure>(model, wide.bindings, std::ssize(wide.parameters)),
      wide.parameters, options, connectors);
  std::vector<ResidualSum::Term> terms;
  for (const auto& each : comparisons) terms.push_back({each.continuation.back(), each.weight});
  return consider_stated(stated, refined.parameters, outcome.parameters,
                         parameter_statistics(refined.parameters, outcome.parameters, outcome.residual),
                         outcome.residual, terms);
}

std::vector<StatedNumber> told(const std::vector<FixedNumber>& stated, const Considered& considered) {
  std::vector<StatedNumber> all;
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const auto& number = stated[i];
    const auto at = static_cast<Index>(i);
    const VectorXd shift = considered.shift.col(at) / number.scale, added = considered.by_number.col(at);
    all.push_back({.name = number.name,
                   .unit = number.unit,
                   .group = group_of(number.kind),
                   .value = number.value,
                   .known_to = number.deviation * number.scale,
                   .allowed = considered.allowed[at] * number.scale,
                   .shift = {shift.begin(), shift.end()},
                   .considered = {added.begin(), added.end()}});
  }
  return all;
}

/// Both kinds of deviations at the end of a search, and what they say with the residual about the numbers.
void judge(const std::vector<MadeComparison>& comparisons, const std::vector<UpdatingParameter>& parameters,
           const LeastSquaresOutcome& outcome, const std::optional<Considered>& considered,
           std::vector<EndOfComparison> ends, UpdateResult& result) {
  const auto& value = outcome.residual;
  if (value.jacobian.size() == 0) {
    result.verdict.add({"failed", "", "the updating has no deviations: " + outcome.reason(),
                        "change the initial values or the bounds", VerdictState::unusable, unusable_widening});
    return;
  }
  auto statistics = parameter_statistics(parameters, outcome.parameters, value);
  if (considered) statistics.considered = considered->deviations;
  const auto robust = robust_statistics(parameters, value, blocks_of(comparisons), statistics);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    result.parameters[i].std = statistics.deviations[at];
    result.parameters[i].std_robust = robust.deviations[at];
    if (considered && std::isfinite(statistics.deviations[at]))
      result.parameters[i].std_considered = std::hypot(statistics.deviations[at], considered->deviations[at]);
    if (const auto interval = parameter_interval(parameters[i], at, outcome.parameters[at], statistics, robust))
      result.parameters[i].interval_95 = {interval->lower, interval->upper};
  }
  result.verdict.add(updating_reasons({.parameters = parameters,
                                       .values = outcome.parameters,
                                       .statistics = statistics,
                                       .robust = robust,
                                       .comparisons = std::move(ends),
                                       .converged = outcome.usable(),
                                       .termination = outcome.reason()}));
}

}  // namespace

UpdateResult update(const Structure& structure, const UpdateOptions& options) {
  auto used = names_of_parameters(options);
  for (const auto& stated : options.known_to) used.push_back(stated.name);
  const auto model = make_structure_model(structure.description(), {.parameters = std::move(used)});
  const Refined found = refined(*model, options);
  const auto& [parameters, bindings] = found;
  require_definite(model, found);
  const auto comparisons = make_comparisons(
      structure, model, std::make_shared<const ParameterisedStructure>(model, bindings, std::ssize(parameters)),
      parameters, options);
  const VectorXd start = initial_values(parameters);
  const ResidualValue first = first_values(sum_of(comparisons, std::numeric_limits<std::size_t>::max()), parameters);
  const auto stated = stated_of(*model, comparisons, options);
  auto outcome = search(comparisons, parameters, options);
  const auto considered = considered_at_end(structure, model, found, stated, outcome, options);

  UpdateResult result{.before = before_updating(comparisons, parameters, first),
                      .converged = outcome.usable(),
                      .reason = outcome.reason()};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    result.parameters.push_back({.name = parameters[i].name,
                                 .unit = parameters[i].unit,
                                 .initial = start[at],
                                 .value = outcome.parameters[at],
                                 .std = std::numeric_limits<double>::infinity()});
  }
  if (considered) {
    outcome.residual.values = considered->residual;
    result.stated_numbers = told(stated, *considered);
  }
  const VectorXd last = outcome.residual.values.size() > 0 ? outcome.residual.values : first.values;
  judge(comparisons, parameters, outcome, considered,
        compare(comparisons, start, first.values, outcome.parameters, last, result), result);
  return result;
}

}  // namespace kalfem
