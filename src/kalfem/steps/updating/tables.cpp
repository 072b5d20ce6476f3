// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/updating/parameter_interval.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

std::string finite(double value) { return std::isfinite(value) ? four_digits(value) : "-"; }

/// A column for each parameter, in the unit that suits its initial value.
std::vector<DisplayUnit> units_of_columns(const Study& study, Table& table) {
  std::vector<DisplayUnit> units;
  for (const auto& parameter : study.updating->parameters) {
    units.emplace_back(parameter.unit, std::vector{parameter.initial, parameter.scale()});
    table.columns.push_back(parameter.name + " [" + units.back().unit() + "]");
  }
  return units;
}

/// The values of the parameters behind what the last row holds.
void add_values(const Eigen::VectorXd& values, const std::vector<DisplayUnit>& units, Table& table) {
  for (std::size_t i = 0; i < units.size(); ++i)
    table.rows.back().push_back(units[i].value(values[static_cast<Index>(i)]));
}

/// The lines of `table` under its title, nothing without rows.
std::string section(const std::string& title, const Table& table) {
  return table.rows.empty() ? "" : title + "\n" + to_text(table) + "\n";
}

}  // namespace

double mean_frequency_error(const std::vector<PairedMode>& modes) {
  double sum = 0.0;
  int count = 0;
  for (const auto& mode : modes)
    if (mode.model_mode) {
      sum += std::abs(mode.relative_error);
      ++count;
    }
  return count > 0 ? sum / count : std::nan("");
}

static bool is_at_bound(const UpdatingOutcome& outcome, std::size_t i) {
  return i < outcome.statistics.at_bound.size() && outcome.statistics.at_bound[i];
}

/// NaN of a parameter at its bound, and where there are no statistics.
static double deviation_of(const Eigen::VectorXd& deviations, const UpdatingOutcome& outcome, std::size_t i) {
  const bool known = static_cast<Index>(i) < deviations.size() && !is_at_bound(outcome, i);
  return known ? deviations[static_cast<Index>(i)] : std::numeric_limits<double>::quiet_NaN();
}

Table updated_parameter_table(const Study& study, const UpdatingOutcome& outcome) {
  Table table{"Updated parameters",
              {"parameter", "unit", "initial", "updated", "95 % interval", "from", "change", "std", "robust std",
               "truth", "error"},
              {},
              {}};
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto& truth = study.updating->true_parameters[i];
    const double value = outcome.values[static_cast<Index>(i)];
    const auto interval =
        parameter_interval(parameter, static_cast<Index>(i), value, outcome.statistics, outcome.robust);
    const double std = deviation_of(outcome.statistics.deviations, outcome, i);
    const DisplayUnit shown(parameter.unit, {value, parameter.initial, std}, study.written_unit(parameter.name));
    const auto deviation = [&](const Eigen::VectorXd& deviations) {
      return is_at_bound(outcome, i) ? "at its bound" : shown.deviation(deviation_of(deviations, outcome, i));
    };
    table.rows.push_back(
        {parameter.name, shown.unit(), shown.value(parameter.initial), shown.value(value, std),
         interval ? shown.value(interval->lower, std) + " to " + shown.value(interval->upper, std) : "-",
         !interval              ? "-"
         : interval->considered ? "known_to"
         : interval->robust     ? "robust std"
                                : "std",
         parameter.initial != 0.0 ? signed_per_cent(value / parameter.initial - 1.0) : "-",
         deviation(outcome.statistics.deviations), deviation(outcome.robust.deviations),
         truth ? shown.value(*truth) : "-", truth && *truth != 0.0 ? signed_per_cent(value / *truth - 1.0) : "-"});
  }
  return without_empty_columns(std::move(table));
}

Table comparison_table(const UpdatingOutcome& outcome) {
  Table table{
      "Comparisons (standard deviations)", {"comparison", "of", "values", "weight", "rms before", "rms after"}, {}, {}};
  for (const auto& each : outcome.comparisons)
    table.rows.push_back({each.name, each.kind, std::to_string(each.size), four_digits(each.weight),
                          finite(each.rms_initial), finite(each.rms_final)});
  return table;
}

Table paired_mode_table(const ComparisonResult& comparison) {
  Table table{"Modes of '" + comparison.name + "'",
              {"measured [Hz]", "before [Hz]", "error", "after [Hz]", "error", "MAC", "out of phase", "damping [%]",
               "before [%]", "after [%]"},
              {},
              {}};
  const auto per_cent_of = [](const std::optional<double>& ratio) { return ratio ? four_digits(100.0 * *ratio) : "-"; };
  for (std::size_t i = 0; i < comparison.modes_final.size(); ++i) {
    const auto& before = comparison.modes_initial[i];
    const auto& after = comparison.modes_final[i];
    table.rows.push_back({four_digits(after.measured_frequency), four_digits(before.model_frequency),
                          signed_per_cent(before.relative_error), four_digits(after.model_frequency),
                          signed_per_cent(after.relative_error), fmt::format("{:.3f}", after.mac),
                          after.complexity > 0.0 ? fmt::format("{:.1f} %", 100.0 * after.complexity) : "-",
                          per_cent_of(after.measured_damping), per_cent_of(before.model_damping),
                          per_cent_of(after.model_damping)});
  }
  return without_empty_columns(std::move(table));
}

Table updating_trace_table(const Study& study, const UpdatingOutcome& outcome) {
  Table table{"Iterations", {"iteration", "residual", "accepted", "time"}, {}, {}};
  const auto units = units_of_columns(study, table);
  for (std::size_t i = 0; i < outcome.trace.size(); ++i) {
    const auto& step = outcome.trace[i];
    table.rows.push_back({std::to_string(i + 1), finite(step.residual), step.accepted ? "yes" : "no",
                          fmt::format("{:.2f} s", step.seconds)});
    add_values(step.tried, units, table);
  }
  return table;
}

Table minima_table(const Study& study, const UpdatingOutcome& outcome) {
  constexpr std::size_t most = 20;
  Table table{"Ends of the searches from all starts", {"cost", "residual", "starts", "converged"}, {}, {}};
  const auto units = units_of_columns(study, table);
  for (std::size_t k = 0; k < std::min(most, outcome.minima.size()); ++k) {
    const auto& minimum = outcome.minima[k];
    table.rows.push_back({finite(minimum.cost), finite(minimum.residual), std::to_string(minimum.reached),
                          minimum.converged ? "yes" : "no"});
    add_values(minimum.parameters, units, table);
  }
  return table;
}

Table frequency_sensitivity_table(const Study& study, const FrequencySensitivities& sensitivities, std::size_t most) {
  Table table{fmt::format("Before the updating: d ln f / d ln parameter of '{}'", sensitivities.comparison),
              {"parameter"},
              {},
              {}};
  const Index modes = std::min(sensitivities.measured.size(), static_cast<Index>(most));
  for (Index i = 0; i < modes; ++i) table.columns.push_back(four_digits(sensitivities.measured[i]) + " Hz");
  for (std::size_t j = 0; j < study.updating->parameters.size(); ++j) {
    table.rows.push_back({study.updating->parameters[j].name});
    for (Index i = 0; i < modes; ++i)
      table.rows.back().push_back(fmt::format("{:.4f}", sensitivities.relative(i, static_cast<Index>(j))));
  }
  return table;
}

/// How the first modes follow the parameters, and what the measurement does not tell of these.
static std::string told_before(const Study& study, const UpdatingOutcome& outcome) {
  constexpr std::size_t shown_modes = 8;
  std::string text;
  for (const auto& each : outcome.first.frequencies) {
    const Table table = frequency_sensitivity_table(study, each, shown_modes);
    text += section(table.title, table);
  }
  return text + first_words(study, outcome) + "\n";
}

std::string first_words(const Study& study, const UpdatingOutcome& outcome) {
  std::string words;
  for (const auto& remark : outcome.first.remarks) words += "  " + remark + "\n";
  for (const auto& sentence : proposal_in_words(study.updating->parameters, outcome.first.proposal))
    words += "  Proposed: " + sentence + ".\n";
  return words;
}

Table sensitivity_table(const UpdatingOutcome& outcome) {
  Table table{"Derivatives against finite differences", {"parameter", "deviation", "uncertainty", "verdict"}, {}, {}};
  for (const auto& each : outcome.sensitivities)
    table.rows.push_back({each.parameter, fmt::format("{:.1e}", each.deviation),
                          fmt::format("{:.1e}", each.uncertainty), explain(each.verdict)});
  return table;
}

Table before_and_after_table(const Study& study, const StudyResults& results) {
  Table table{"Unknowns of the filter before and after the updating",
              {"parameter", "unit", "truth", "without", "error", "with", "error"},
              {},
              {}};
  const auto* estimation = results.find<EstimationOutcome>();
  const auto& unknowns_before = results.get<UpdatingOutcome>().unknowns_before;
  if (!estimation || unknowns_before.size() == 0) return table;
  const auto& unknowns = estimation->augmented_model->options().unknowns;
  const auto& after = estimation->result.unknowns.mean;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const double without = unknowns_before[row], with = after(row, after.cols() - 1);
    const auto& truth = study.augmented_model->true_parameters[i];
    const auto error = [&](double value) {
      return truth && *truth != 0.0 ? signed_per_cent(value / *truth - 1.0) : "-";
    };
    table.rows.push_back({unknowns[i].name, unknowns[i].unit, truth ? four_digits(*truth) : "-", four_digits(without),
                          error(without), four_digits(with), error(with)});
  }
  return table;
}

std::string considered_words(const Study& study, const UpdatingOutcome& outcome) {
  std::string words;
  const auto& considered = *outcome.considered;
  for (Index j = 0; j < considered.by_number.rows(); ++j) {
    const double noise = outcome.statistics.deviations[j];
    if (!std::isfinite(noise)) continue;
    Index largest = 0;
    const double most = considered.by_number.row(j).maxCoeff(&largest);
    const auto& parameter = study.updating->parameters[static_cast<std::size_t>(j)];
    words += fmt::format("  {}: of +- {:.2g} {}, {:.2g} are of what was measured, {:.2g} '{}'\n", parameter.name,
                         std::hypot(noise, considered.deviations[j]), parameter.unit, noise, most,
                         study.updating_plan->stated[static_cast<std::size_t>(largest)].name);
  }
  return words;
}

std::string updating_answer(const UpdatingOutcome& outcome) {
  return fmt::format("{} of the model updated: the residual decreased from {} to {} standard deviations.",
                     counted(outcome.values.size(), "parameter"), four_digits(outcome.residual_initial),
                     four_digits(outcome.residual_final));
}

Table alternatives_table(const UpdatingOutcome& outcome) {
  Table table{"Choices of parameters", {"choice", "parameters", "residual", "ln evidence", "weight"}, {}, {}};
  const auto add = [&](const std::string& name, const UpdatingOutcome& of, const std::string& failure) {
    const std::string count = std::to_string(of.values.size());
    if (failure.empty())
      table.rows.push_back({name, count, finite(of.residual_final), fmt::format("{:.2f}", *of.log_evidence),
                            fmt::format("{:.3g} %", 100.0 * of.weight)});
    else
      table.rows.push_back({name, count, "-", "-", failure});
  };
  if (outcome.alternatives.empty()) return table;
  add("as given", outcome, "");
  for (const auto& each : outcome.alternatives) add(each.plan->name, each.outcome, each.failure);
  return table;
}

std::string console_updating(const Study& study, const StudyResults& results) {
  const auto& outcome = results.get<UpdatingOutcome>();
  std::string text = fmt::format(
      "Updated in {} evaluations ({} steps), {:.1f} s: {}{}\nby {}\n", outcome.evaluations, outcome.iterations,
      outcome.seconds, outcome.termination,
      outcome.resumed_at > 0 ? fmt::format("; {} evaluations come from an earlier run", outcome.resumed_at) : "",
      outcome.method);
  text += fmt::format("residual {} -> {} standard deviations\n\n", finite(outcome.residual_initial),
                      finite(outcome.residual_final));
  if (!outcome.first.remarks.empty()) text += told_before(study, outcome);
  text += section("Updated parameters", updated_parameter_table(study, outcome));
  for (const auto& remark : outcome.remarks) text += "  " + remark + "\n";
  if (!outcome.remarks.empty()) text += "\n";
  if (outcome.considered) text += considered_words(study, outcome) + "\n";
  text += section("Comparisons (standard deviations)", comparison_table(outcome));
  for (const auto& each : outcome.comparisons)
    if (!each.derivatives.empty()) text += "  derivatives of '" + each.name + "' by " + each.derivatives + "\n\n";
  for (const auto& each : outcome.comparisons)
    if (!each.modes_final.empty())
      text += section(fmt::format("Modes of '{}': mean error {} before, {} after", each.name,
                                  per_cent(mean_frequency_error(each.modes_initial)),
                                  per_cent(mean_frequency_error(each.modes_final))),
                      paired_mode_table(each));
  text += section("Choices of parameters, by the evidence of what was measured", alternatives_table(outcome));
  text += section("Ends of the searches from all starts", minima_table(study, outcome));
  text += section("Derivatives against finite differences", sensitivity_table(outcome));
  text += section("Unknowns of the filter before and after the updating", before_and_after_table(study, results));
  return text;
}

std::string console_updating_step(const Study& study, int number, const UpdatingStep& step) {
  std::string line =
      fmt::format("iteration {:2}: residual {}{}", number, finite(step.residual), step.accepted ? "" : " (kept)");
  constexpr std::size_t most_named = 4;
  const auto& parameters = study.updating->parameters;
  for (std::size_t i = 0; i < std::min(parameters.size(), most_named); ++i)
    line += fmt::format(", {} {}", parameters[i].name, four_digits(step.tried[static_cast<Index>(i)]));
  if (parameters.size() > most_named) line += fmt::format(", {} more", parameters.size() - most_named);
  return line + fmt::format(", {:.1f} s\n", step.seconds);
}

}  // namespace kalfem
