// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/compute.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/diagnosis/judge_updating.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/steps/updating/search.hpp"
#include "kalfem/updating/evidence.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/sensitivity_check.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using Parameters = std::vector<UpdatingParameter>;

std::vector<FrfCurve> curves(const FrfResidual& residual, const VectorXd& start, const VectorXd& end) {
  std::vector<FrfCurve> all;
  const auto before = residual.model_responses(start), after = residual.model_responses(end);
  const auto scales_before = residual.scales(before), scales_after = residual.scales(after);
  for (std::size_t i = 0; i < residual.compared().size(); ++i) {
    const auto& measured = residual.compared()[i];
    const auto& set = residual.sets()[i];
    for (Index j = 0; j < measured.values.cols(); ++j)
      all.push_back({.name = set.outputs[static_cast<std::size_t>(j)] + per_input(set),
                     .quantity = name_of(set.quantity),
                     .unit = unit_of(set),
                     .lines = measured.lines,
                     .measured = measured.values.col(j),
                     .before = scales_before[i][j] * before[i].col(j),
                     .after = scales_after[i][j] * after[i].col(j),
                     .magnitudes_only = measured.magnitudes_only,
                     .coherence = measured.coherence.size() > 0 ? VectorXd(measured.coherence.col(j)) : VectorXd(),
                     .scale = residual.has_free_scale() ? std::optional(scales_after[i][j]) : std::nullopt});
  }
  return all;
}

/// The rows of each comparison in the sum, as sum_of() puts them.
std::vector<ResidualBlock> blocks_of(const std::vector<ComparisonResidual>& comparisons) {
  std::vector<ResidualBlock> blocks;
  Index first = 0;
  for (const auto& comparison : comparisons) {
    const auto& residual = *comparison.continuation_steps.back();
    blocks.push_back({comparison.name, first, residual.size(), residual.layout()});
    first += residual.size();
  }
  return blocks;
}

std::vector<ComparedResidual> compared(const std::vector<ComparisonResidual>& comparisons) {
  std::vector<ComparedResidual> all;
  for (const auto& each : comparisons) all.push_back({each.name, each.continuation_steps.back(), each.weight});
  return all;
}

/// Rms of each comparison at the start and at the end, with its modes or frequency lines if it has any.
void compare(const Study& study, const std::vector<ComparisonResidual>& comparisons, const ResidualValue& first,
             const ResidualValue& last, UpdatingOutcome& updating) {
  const VectorXd start = initial_values(study.updating->parameters);
  Index row = 0;
  for (const auto& comparison : comparisons) {
    const auto& residual = *comparison.continuation_steps.back();
    ComparisonResult result;
    result.name = comparison.name;
    result.kind = comparison.kind;
    result.weight = comparison.weight;
    result.size = residual.size();
    const auto rms = [&](const ResidualValue& value) {
      return rms_of(0.5 * value.values.segment(row, result.size).squaredNorm(), result.size) /
             std::sqrt(comparison.weight);
    };
    result.rms_initial = rms(first);
    result.rms_final = rms(last);
    row += result.size;
    result.has_bounds = has_bounds(residual);
    if (const auto* modal = dynamic_cast<const ModalResidual*>(&residual)) {
      const auto at_start = modal->compare(start), at_end = modal->compare(updating.values);
      result.modes_initial = at_start.pairs;
      result.modes_final = at_end.pairs;
      result.mac_initial = at_start.mac;
      result.mac_final = at_end.mac;
    }
    if (const auto* record = dynamic_cast<const RecordResidual*>(&residual)) result.derivatives = record->derivatives();
    if (const auto* frf = finest_responses(comparison.continuation_steps))
      result.responses = curves(*frf, start, updating.values);
    updating.comparisons.push_back(std::move(result));
  }
}

bool has_driven_record(const std::vector<ComparisonResidual>& comparisons) {
  return std::ranges::any_of(comparisons, [](const ComparisonResidual& each) {
    return dynamic_cast<const RecordResidual*>(each.continuation_steps.back().get()) != nullptr;
  });
}

/// Residuals of records use finite differences themselves, so they agree less closely; those of driven records are
/// one-sided or leave out the change of the gains.
SensitivityCheckOptions check_options(const std::vector<ComparisonResidual>& comparisons) {
  constexpr double of_driven_records = 0.1;
  SensitivityCheckOptions options;
  if (std::ranges::any_of(comparisons, &ComparisonResidual::of_record))
    options.tolerance = has_driven_record(comparisons) ? of_driven_records : SimulationResidual::derivative_error;
  return options;
}

bool scatter(const std::vector<SensitivityComparison>& comparisons) {
  return std::ranges::any_of(comparisons, [](const SensitivityComparison& each) {
    return each.verdict == SensitivityComparison::Verdict::undecided;
  });
}

/// Says why a search stalled, from derivatives at its end: the same check that the case may ask for at the start. A
/// driven record is not checked unless asked for, as each difference is a filter pass. On a residual that is not
/// smooth, a search may also come to short steps by chance: that is no convergence either.
void explain_end(const Study& study, const std::vector<ComparisonResidual>& comparisons, const ResidualSum& residual,
                 UpdatingOutcome& updating) {
  const bool stalled = updating.end == Termination::no_progress;
  if (!stalled && !scatter(updating.sensitivities)) return;
  if (has_driven_record(comparisons) && !study.updating_plan->check_sensitivities) return;
  const auto found =
      check_sensitivities(residual, study.updating->parameters, updating.values, check_options(comparisons));
  if (stalled) {
    updating.termination += "; " + explain_stall(found);
  } else if (scatter(found)) {
    updating.converged = false;
    updating.termination = "not converged: the steps became short, but " + explain_stall(found);
  }
}

/// A comparison with the record as a residual.
ComparisonResidual with_record(const Study& study, const RecordComparison& given, const Record& record) {
  const auto& structure = study.updating_plan->structure;
  ResidualPtr residual;
  if (const auto* simulated = std::get_if<RecordComparison::OfSimulation>(&given.what))
    residual = std::make_shared<SimulationResidual>(study.structure, simulated->sensors, record, structure,
                                                    study.updating->parameters, simulated->options);
  else
    residual = std::make_shared<RecordResidual>(study.problem, record, structure, *study.updating,
                                                std::get<RecordResidual::Options>(given.what));
  return {given.name, given.kind, {residual}, given.weight, true};
}

[[noreturn]] void refuse_first_values(const Study& study) {
  throw InvalidInput(Issue{study.updating_plan->location,
                           "update.parameters: the model has no response at the initial values",
                           "the updating starts from these values", "change the initial values"});
}

/// Throws InvalidInput with the place of every parameter that the comparisons do not depend on.
void require_effects(const Study& study, const Eigen::MatrixXd& jacobian) {
  IssueList issues;
  for (const auto& name : without_effect(study.updating->parameters, jacobian))
    issues.add(study.updating_plan->parameter_locations.at(name),
               "update.parameters." + name + ": no comparison depends on this parameter",
               "a measurement must depend on a parameter to identify it",
               "remove it or compare with a measurement that depends on it");
  issues.raise();
}

/// The sum, at the initial values, of the comparisons that need no record; nothing if there are none.
std::optional<ResidualValue> first_values_without_record(const Study& study,
                                                         std::vector<ComparisonResidual> comparisons) {
  std::erase_if(comparisons, [](const ComparisonResidual& each) { return each.of_record; });
  if (comparisons.empty()) return std::nullopt;
  const ResidualSum residual = last_sum(comparisons);
  auto value = residual.evaluate(initial_values(study.updating->parameters), true);
  if (!value) refuse_first_values(study);
  return value;
}

/// States why there is no residual at the initial values if the comparisons with the record are the reason.
std::string failure_at_first_values(const Study& study, const std::vector<ComparisonResidual>& comparisons) {
  first_values_without_record(study, comparisons);
  return "at the initial values of the updated parameters the filter or the simulation of the record fails; change "
         "these values or the priors of the filter's unknowns";
}

/// What stated numbers add at the end of the search; the residual there becomes that with the numbers as the data ask
/// for within what is stated.
void consider_stated(const Study& study, const StudyResults& results, UpdatingOutcome& updating, ResidualValue& last) {
  const UpdatingPlan& plan = *study.updating_plan;
  if (plan.stated.empty()) return;
  Study wide = study;
  wide.updating = plan.wide->setup;
  wide.updating_plan = plan.wide->plan;
  std::vector<ResidualSum::Term> terms;
  for (const auto& each : all_comparisons(wide, results))
    terms.push_back({each.continuation_steps.back(), each.weight});
  const auto& parameters = study.updating->parameters;
  updating.considered = kalfem::consider_stated(plan.stated, parameters, updating.values,
                                                parameter_statistics(parameters, updating.values, last), last, terms);
  if (updating.considered) last.values = updating.considered->residual;
}

std::string unusable(const UpdatingOutcome& updating, const LastResidual& last) {
  if (!last || !std::isfinite(updating.residual_final) || !updating.values.allFinite())
    return "the updating found no parameter values at which the model has a response";
  return "";
}

}  // namespace

std::vector<ComparisonResidual> all_comparisons(const Study& study, const StudyResults& results) {
  const UpdatingPlan& plan = *study.updating_plan;
  auto all = plan.comparisons;
  if (plan.record_comparisons.empty()) return all;
  const Record& record = record_of(study, results);
  IssueList issues;
  for (const auto& given : plan.record_comparisons) try {
      all.push_back(with_record(study, given, record));
    } catch (const InvalidInput& error) {
      add_at(given.location, error, issues);
    }
  issues.raise();
  return all;
}

// 1. Evaluate the residual of the last continuation step with its Jacobian at the initial values. Each parameter must
//    have an effect.
// 2. Search by the plan's method, see search().
// 3. Evaluate at the end point for the statistics: covariance, identifiability, and each comparison before and after.
UpdatingOutcome run_updating(const Study& study, const StudyResults& results, const RunOptions& options,
                             std::string& failure) {
  const Stopwatch watch;
  const UpdatingPlan& plan = *study.updating_plan;
  const Parameters& parameters = study.updating->parameters;
  const std::vector<ComparisonResidual> comparisons = all_comparisons(study, results);
  const ResidualSum residual = last_sum(comparisons);
  UpdatingOutcome updating;
  updating.values = initial_values(parameters);
  const auto first = residual.evaluate(updating.values, true);
  if (!first) {
    failure = failure_at_first_values(study, comparisons);
    return updating;
  }
  require_effects(study, first->jacobian);
  updating.first = first_information(parameters, *first, compared(comparisons));
  updating.residual_initial = rms_of(0.5 * first->values.squaredNorm(), residual.size());
  if (plan.check_sensitivities)
    updating.sensitivities = check_sensitivities(residual, parameters, updating.values, check_options(comparisons));

  LastResidual last = search(study, comparisons, *first, options, updating);
  explain_end(study, comparisons, residual, updating);
  if (!last || last->jacobian.size() == 0) last = residual.evaluate(updating.values, true);
  if (last && last->jacobian.size() > 0) consider_stated(study, results, updating, *last);
  if (last) updating.residual_final = rms_of(0.5 * last->values.squaredNorm(), residual.size());
  failure = unusable(updating, last);
  if (failure.empty()) {
    updating.statistics = parameter_statistics(parameters, updating.values, *last);
    if (updating.considered) updating.statistics.considered = updating.considered->deviations;
    updating.robust = robust_statistics(parameters, *last, blocks_of(comparisons), updating.statistics);
    updating.remarks = parameter_findings(parameters, updating.values, updating.statistics);
    compare(study, comparisons, *first, *last, updating);
    if (std::ranges::all_of(parameters, [](const auto& each) { return std::isfinite(each.deviation); }))
      updating.log_evidence = log_evidence(parameters, updating.values, *last);
  }
  updating.seconds = watch.seconds();
  return updating;
}

void check_first_values(const Study& study) {
  const auto first = first_values_without_record(study, study.updating_plan->comparisons);
  if (first && study.updating_plan->record_comparisons.empty()) require_effects(study, first->jacobian);
}

}  // namespace kalfem
