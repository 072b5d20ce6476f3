// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/updating_checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

namespace {

constexpr double chance = 3.2e-5;  ///< of a normal variable beyond four deviations on one side
constexpr double far = 4.0;        ///< prior standard deviations

std::string value_of(double value, const std::string& unit) {
  return fmt::format("{:.4g}{}{}", value, unit.empty() || unit == "-" ? "" : " ", unit == "-" ? "" : unit);
}

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "'" : i + 1 == items.size() ? " and '" : ", '") + items[i] + "'";
  return text;
}

/// Whether a mean square is above (or below) one by more than chance gives, where so many values are independent.
bool is_above(double ratio, double freedom) {
  return freedom > 0.0 && freedom * ratio * ratio > chi_squared_quantile(1.0 - chance, freedom);
}
bool is_below(double ratio, double freedom) {
  return freedom > 0.0 && freedom * ratio * ratio < chi_squared_quantile(chance, freedom);
}

void check_size(const ComparedMeasurement& comparison, std::vector<Reason>& reasons) {
  const double freedom = comparison.degrees_of_freedom, inverse = 1.0 / std::max(comparison.rms, 1e-12);
  if (state_of(comparison.rms) != VerdictState::consistent && is_above(comparison.rms, freedom))
    reasons.push_back({"residual_large", comparison.name,
                       fmt::format("after the updating, comparison '{}' still differs by {:.3g} of its stated standard "
                                   "deviations (expected 1)",
                                   comparison.name, comparison.rms),
                       "the model cannot follow the measurement: look for a wrong fixed parameter, a missing part or a "
                       "wrong unit; where it can, state larger deviations",
                       state_of(comparison.rms), comparison.rms});
  if (!comparison.has_bounds && state_of(inverse) != VerdictState::consistent && is_below(comparison.rms, freedom))
    reasons.push_back({"residual_small", comparison.name,
                       fmt::format("after the updating, comparison '{}' differs by only {:.2g} of its stated standard "
                                   "deviations (expected 1): they are stated too large, and so are those of the "
                                   "parameters",
                                   comparison.name, comparison.rms),
                       "state smaller deviations of this measurement", VerdictState::suspicious,
                       std::min(inverse, unusable_widening)});
}

void check_pairs(const ComparedMeasurement& comparison, std::vector<Reason>& reasons) {
  if (comparison.poor_pairs.empty()) return;
  reasons.push_back({"poor_pairs", comparison.name,
                     fmt::format("in comparison '{}' no mode of the model agrees with the measured one at {}",
                                 comparison.name, fmt::join(comparison.poor_pairs, ", ")),
                     "compare the shapes, name the mode with model_modes, or leave the measured mode out",
                     VerdictState::suspicious, suspicious_widening});
}

void check_bound(const UpdatedValue& parameter, std::vector<Reason>& reasons) {
  if (!parameter.at_bound) return;
  reasons.push_back(
      {"at_bound", parameter.name,
       fmt::format("parameter '{}' ended at its bound, {}: the residual would be smaller beyond it", parameter.name,
                   value_of(parameter.value, parameter.unit)),
       "widen the bounds if a value beyond is physical; otherwise another part of the model is wrong, and "
       "this parameter makes up for it",
       VerdictState::suspicious, suspicious_widening});
}

void check_prior(const UpdatedValue& parameter, std::vector<Reason>& reasons) {
  if (!parameter.prior_deviation) return;
  const double moved = std::abs(parameter.value - parameter.initial) / *parameter.prior_deviation;
  if (!(moved > far)) return;
  reasons.push_back({"far_from_prior", parameter.name,
                     fmt::format("parameter '{}' ended at {}, {:.3g} prior standard deviations from its initial value "
                                 "{:.4g}",
                                 parameter.name, value_of(parameter.value, parameter.unit), moved, parameter.initial),
                     "check the measurement and the model's fixed values; widen the prior only if the new value is "
                     "plausible",
                     VerdictState::suspicious, moved});
}

void check_sign(const UpdatedValue& parameter, std::vector<Reason>& reasons) {
  if (!parameter.positive_by_nature || parameter.value > 0.0 || parameter.at_bound) return;
  if (parameter.value == 0.0 && parameter.initial == 0.0) return;
  reasons.push_back({"unphysical_sign", parameter.name,
                     fmt::format("parameter '{}' ended at {}; it is positive by nature", parameter.name,
                                 value_of(parameter.value, parameter.unit)),
                     "give it a lower bound above 0, and check the signs and units of the measurement",
                     VerdictState::unusable, unusable_widening});
}

/// Where the model follows the measurement, robust deviations allow for correlated residuals, and the interval that a
/// reader sees first is theirs. Where it does not, they allow for its errors on this measurement only.
void check_widening(const UpdatedValue& parameter, std::vector<Reason>& reasons) {
  if (state_of(parameter.widening) == VerdictState::consistent ||
      !is_above(parameter.widening, parameter.widening_freedom))
    return;
  reasons.push_back(
      {"deviation_too_small", parameter.name,
       fmt::format("the standard deviation of parameter '{}' is {:.2g} times too small, because residuals "
                   "are correlated or the measurements contradict each other",
                   parameter.name, parameter.widening),
       "rely on std_robust in the place of std, and look for what the model misses", state_of(parameter.widening),
       parameter.widening});
}

/// Those of the parameters for which no prior is stated.
std::vector<std::string> without_prior(const std::vector<std::string>& names, const UpdatingRecord& record) {
  std::vector<std::string> without;
  for (const auto& name : names) {
    const auto found = std::ranges::find(record.parameters, name, &UpdatedValue::name);
    if (found == record.parameters.end() || !found->prior_deviation) without.push_back(name);
  }
  return without;
}

/// A prior is advised only where none is stated: where there is one, the value comes from it already.
void check_information(const UpdatingRecord& record, std::vector<Reason>& reasons) {
  for (const auto& name : record.not_identified) {
    const bool has_prior = without_prior({name}, record).empty();
    reasons.push_back({"not_identified", name,
                       fmt::format("the measurements hardly determine parameter '{}'{}", name,
                                   has_prior ? ": its value and deviation are about those of its prior" : ""),
                       has_prior
                           ? "hold it at its value, or compare with a measurement that depends on it"
                           : "hold it at its value, give it a prior, or compare with a measurement that depends on it",
                       VerdictState::suspicious, 1.0});
  }
  for (const auto& names : record.not_told_apart) {
    const auto without = without_prior(names, record);
    reasons.push_back({"correlated", fmt::format("{}", fmt::join(names, ", ")),
                       fmt::format("the measurements cannot tell parameters {} apart{}", listed(names),
                                   without.empty() ? ": their priors decide how a change is shared" : ""),
                       without.empty()
                           ? "hold one of them, or add measurements that separate them"
                           : fmt::format("hold one of them, give {} a prior, or add measurements that separate them",
                                         listed(without)),
                       VerdictState::suspicious, 1.0});
  }
}

}  // namespace

std::vector<Reason> updating_reasons(const UpdatingRecord& record) {
  std::vector<Reason> reasons;
  if (!record.converged)
    reasons.push_back({"not_converged", "update", "the updating did not converge: " + record.termination,
                       "start nearer, refine fewer parameters, or allow more iterations (update.stages)",
                       VerdictState::suspicious, suspicious_widening});
  for (const auto& comparison : record.comparisons) {
    check_size(comparison, reasons);
    check_pairs(comparison, reasons);
  }
  const bool followed = std::ranges::all_of(
      record.comparisons, [](const auto& each) { return state_of(each.rms) == VerdictState::consistent; });
  for (const auto& parameter : record.parameters) {
    check_bound(parameter, reasons);
    check_prior(parameter, reasons);
    check_sign(parameter, reasons);
    if (!followed) check_widening(parameter, reasons);
  }
  check_information(record, reasons);
  return reasons;
}

}  // namespace kalfem
