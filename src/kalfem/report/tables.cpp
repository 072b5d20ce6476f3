// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/tables.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/identification/walked_range.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/report/adaptive_noise_report.hpp"
#include "kalfem/report/display_unit.hpp"
#include "kalfem/report/frequency_report.hpp"
#include "kalfem/report/frequency_response_report.hpp"
#include "kalfem/report/inference_report.hpp"
#include "kalfem/report/modes_table.hpp"
#include "kalfem/report/placement_report.hpp"
#include "kalfem/report/process_noise_report.hpp"
#include "kalfem/report/statics_report.hpp"
#include "kalfem/report/summary_parts.hpp"
#include "kalfem/report/updating_tables.hpp"
#include "kalfem/study/structural_modifications.hpp"

namespace kalfem {
namespace {

const char* short_name(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
    case ObservedQuantity::connector_deformation:
      return "displacement";
    case ObservedQuantity::velocity:
    case ObservedQuantity::connector_rate:
      return "velocity";
    case ObservedQuantity::acceleration:
      return "acceleration";
    case ObservedQuantity::connector_force:
      return "force";
    case ObservedQuantity::strain:
      return "strain";
  }
  return "";
}

/// Length as shown: UTF-8 continuation bytes take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t columns, bool right) {
  const std::string blank(columns - std::min(columns, width(text)), ' ');
  return right ? blank + text : text + blank;
}

std::string band_words(const EstimationOutcome& outcome) {
  return outcome.band ? fmt::format(" (band of the excitation: {} to {} Hz)", four_digits(outcome.band->from),
                                    four_digits(outcome.band->to))
                      : std::string();
}

}  // namespace

bool shown(const Study& study, const PointQuantity& quantity) {
  const auto& point = quantity.point;
  const auto& wanted =
      quantity.quantity == ObservedQuantity::strain ? study.report.strains : study.report.displacements;
  const bool of_elements = std::ranges::any_of(
      study.structure->finite_elements, [&](const auto& each) { return point.starts_with(each.part->name + "."); });
  return !of_elements || wanted.empty() || std::ranges::any_of(wanted, [&](const auto& name) { return name == point; });
}

std::string per_cent(double ratio) { return std::isfinite(ratio) ? fmt::format("{:.2f} %", 100.0 * ratio) : "-"; }

Table without_empty_columns(Table table) {
  for (std::size_t c = table.columns.size(); c-- > 1;) {
    if (std::ranges::any_of(table.rows, [c](const auto& row) { return row[c] != "-"; })) continue;
    const auto at = static_cast<std::ptrdiff_t>(c);
    table.columns.erase(table.columns.begin() + at);
    for (auto& row : table.rows) row.erase(row.begin() + at);
  }
  return table;
}

std::string counted(Eigen::Index count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string four_digits(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-"; }

namespace {

void add_likelihood_unknowns(const Study& study, const LikelihoodEstimate& likelihood, Table& table) {
  for (std::size_t i = 0; i < likelihood.unknowns.size(); ++i) {
    const auto& [name, kind, sensor, unit, initial, deviation, truth] = likelihood.unknowns[i];
    const auto row = static_cast<Eigen::Index>(i);
    const double estimate = likelihood.values[row];
    const auto interval = likelihood.interval(row);
    const double std = likelihood.deviation[row], robust = likelihood.robust_deviation[row];
    const DisplayUnit shown(unit, {estimate, initial, std}, study.written_unit(name));
    table.rows.push_back({name, shown.unit(), shown.value(initial), shown.value(estimate, std),
                          shown.value(interval.lower, std) + " to " + shown.value(interval.upper, std),
                          interval.robust ? "robust std" : "std", shown.deviation(std), shown.deviation(robust),
                          truth ? shown.value(*truth) : "-",
                          truth && *truth != 0.0 ? per_cent(estimate / *truth - 1.0) : "-"});
  }
}

}  // namespace

Table parameter_table(const Study& study, const EstimationOutcome& outcome) {
  Table table{
      "Parameters",
      {"parameter", "unit", "initial", "estimate", "95 % interval", "from", "std", "robust std", "truth", "error"},
      {},
      {}};
  const auto last = outcome.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < outcome.augmented_model->options().unknowns.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const auto& unknown = outcome.augmented_model->options().unknowns[i];
    const auto& truth = study.augmented_model->true_parameters[i];
    const double estimate = outcome.result.unknowns.mean(row, last);
    const auto interval = stated_interval(outcome, row);
    const auto range = walked_range(outcome, row);
    const double std = outcome.result.unknowns.deviation(row, last);
    const DisplayUnit shown(unknown.unit, {estimate, unknown.initial, std}, study.written_unit(unknown.name));
    const auto between = [&](double least, double greatest) {
      return shown.value(least, std) + " to " + shown.value(greatest, std);
    };
    table.rows.push_back({unknown.name, shown.unit(), shown.value(unknown.initial),
                          range ? between(range->least, range->greatest) : shown.value(estimate, std),
                          range ? between(range->lower, range->upper) : between(interval.lower, interval.upper),
                          range             ? "all of the record"
                          : interval.robust ? "robust std"
                                            : "std",
                          shown.deviation(std), shown.deviation(outcome.robust_deviation[row]),
                          truth ? shown.value(*truth) : "-",
                          truth && *truth != 0.0 ? per_cent(estimate / *truth - 1.0) : "-"});
  }
  if (outcome.likelihood) add_likelihood_unknowns(study, *outcome.likelihood, table);
  return without_empty_columns(std::move(table));
}

Table input_table(const EstimationOutcome& outcome) {
  Table table{"Unknown excitations",
              {"excitation", "unit", "rms", "std", "std without sensors", "error", "truth in the 95 % band"},
              {},
              {}};
  const auto first = outcome.settled;
  for (const auto& input : outcome.inputs) {
    const auto rms_after = [&](const Eigen::VectorXd& values) {
      const auto after = values.tail(std::max<Eigen::Index>(1, values.size() - first));
      return four_digits(after.norm() / std::sqrt(static_cast<double>(after.size())));
    };
    table.rows.push_back({input.input.name, input.input.unit, rms_after(input.mean), rms_after(input.deviation),
                          input.input.is_random_walk() ? "-" : four_digits(input.input.deviation),
                          input.nrmse ? per_cent(*input.nrmse) : "-",
                          input.coverage ? per_cent(*input.coverage) : "-"});
  }
  return table;
}

std::string hardly_known_words(const EstimationOutcome& outcome) {
  std::string names;
  for (const auto& name : outcome.hardly_known) names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? "" : "The sensors hardly show (standard deviation above half of the size): " + names + ".";
}

Table error_table(const std::string& title, const Study& study, const std::vector<PointQuantity>& points,
                  Eigen::Index settled) {
  const RestingPoints resting(points, settled);
  std::vector<std::string> order;
  std::map<std::string, std::map<std::string, std::string>> cells;
  for (const auto& point : points) {
    if (point.truth.size() == 0 || !shown(study, point)) continue;
    if (!cells.contains(point.point)) order.push_back(point.point);
    const std::string quantity = short_name(point.quantity);
    const bool rests = resting.rests(point);
    cells[point.point][quantity] = rests ? "at rest" : point.nrmse ? per_cent(*point.nrmse) : "-";
    if (point.nrmse_in_band && !rests) cells[point.point][quantity + " in band"] = per_cent(*point.nrmse_in_band);
    if (point.coverage && !rests) cells[point.point]["within ± 1.96 std"] = per_cent(*point.coverage);
  }
  Table table{title,
              {"point", "displacement", "velocity", "acceleration", "acceleration in band", "force", "strain",
               "strain in band", "within ± 1.96 std"},
              {},
              {}};
  const auto used = [&](const std::string& column) {
    return std::ranges::any_of(cells, [&](const auto& row) { return row.second.contains(column); });
  };
  std::erase_if(table.columns, [&](const auto& column) { return column != "point" && !used(column); });
  const auto rests = [&](const auto& own) {
    return std::ranges::all_of(own, [](const auto& cell) { return cell.second == "at rest"; });
  };
  for (const auto& name : order) {
    if (rests(cells[name])) continue;
    std::vector<std::string> row{name};
    for (std::size_t c = 1; c < table.columns.size(); ++c) {
      const auto cell = cells[name].find(table.columns[c]);
      row.push_back(cell == cells[name].end() ? "" : cell->second);
    }
    table.rows.push_back(row);
  }
  return table;
}

Table open_loop_table(const EstimationOutcome& outcome) {
  Table table{"Open loop against the record", {"sensor", "NRMSE about rest", "rest error"}, {}, {}};
  for (std::size_t i = 0; i < outcome.open_loop_nrmse.size(); ++i)
    table.rows.push_back({outcome.measurements.channels[i].name,
                          outcome.open_loop_nrmse[i] < 1e3 ? fmt::format("{:.3f}", outcome.open_loop_nrmse[i])
                                                           : four_digits(outcome.open_loop_nrmse[i]),
                          four_digits(outcome.open_loop_rest_error[i]) + " " + outcome.measurements.channels[i].unit});
  return table;
}

Table validation_table(const ValidationOutcome& outcome) {
  const auto &held_back = outcome.held_back, &own = outcome.own;
  Table table{"Open loop on the validation part",
              {"sensor", "NRMSE", "on the estimated part", "one step ahead", "noise / rms"},
              {},
              {}};
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j)
    table.rows.push_back({held_back.measured.channels[j].name, four_digits(held_back.nrmse[j]),
                          j < own.nrmse.size() ? four_digits(own.nrmse[j]) : "-",
                          j < held_back.one_step.size() ? four_digits(held_back.one_step[j]) : "-",
                          four_digits(held_back.noise[j])});
  return table;
}

std::string validation_part_words(const ValidationPlan& plan) {
  return fmt::format("Validation: {} s to {} s of {}", four_digits(plan.record.record.start),
                     four_digits(plan.record.record.end()), std::filesystem::path(plan.file).filename().string());
}

std::string validation_words(const Study& study, const ValidationOutcome& outcome) {
  const auto& held_back = outcome.held_back;
  const std::string part = validation_part_words(*study.validation);
  if (!held_back.failure.empty()) return part + "; no comparison: " + held_back.failure;
  if (study.validation->from_rest) return part + ", open loop from rest";
  return part +
         fmt::format(", open loop; the initial state is estimated from the samples before {} s, which do not count",
                     four_digits(held_back.measured.time(held_back.first)));
}

std::string to_text(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    widths.push_back(width(table.columns[c]));
    for (const auto& row : table.rows) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c) line += (c ? "   " : "  ") + padded(cells[c], widths[c], c > 0);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  };
  add(table.columns);
  std::size_t total = 0;
  for (const auto w : widths) total += w + 3;
  text += "  " + std::string(total - 3, '-') + "\n";
  for (const auto& row : table.rows) add(row);
  return text;
}

/// How the unknowns of the linear part were followed; nothing where there are none.
std::string linearisation_words(const EstimationOutcome& outcome) {
  if (outcome.reductions == 0 && outcome.result.linearisations == 0) return "";
  return fmt::format("Linear part: relinearised {} times{}\n", outcome.result.linearisations,
                     outcome.reductions > 1
                         ? fmt::format(", reduced {} times, the last time at the estimates", outcome.reductions)
                         : "");
}

std::string substep_words(const EstimationOutcome& outcome) {
  const auto& choice = outcome.substeps;
  const std::string number = fmt::format("{} substep{} per sample", choice.substeps, choice.substeps == 1 ? "" : "s");
  if (!choice.chosen) return number + ", as stated; their bias was not measured";
  const Eigen::Index largest = choice.largest();
  if (largest < 0) return number + ": " + choice.words;
  const auto& unknown = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(largest)];
  return fmt::format("{}, chosen {}: they bias the estimates by at most {:.2g} standard deviations ('{}'){}", number,
                     choice.words, choice.bias[largest], unknown.name,
                     choice.stopped   ? "; more substeps are needed than second_thoughts allow"
                     : choice.limited ? "; more substeps would be needed, but the limit is reached"
                                      : "");
}

std::string speed_in_words(double ratio) {
  return ratio >= 1.0 ? fmt::format("{:.3g} times faster than real time", ratio)
                      : fmt::format("{:.3g} times slower than real time", 1.0 / ratio);
}

/// A line that starts with a capital.
std::string sentence(std::string words) {
  if (!words.empty()) words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  return words + "\n";
}

std::string mass_text(const FiniteElementPart& part) {
  const auto& moving = part.moving_mass;
  std::string text = four_digits(part.mass.mass) + " kg";
  if (moving.minCoeff() >= (1.0 - 1e-9) * part.mass.mass) return text;
  if (moving.maxCoeff() - moving.minCoeff() <= 1e-9 * part.mass.mass)
    return text + fmt::format(" (of which {} kg can move)", four_digits(moving[0]));
  return text + fmt::format(" (of which {}, {} and {} kg can move along x, y and z)", four_digits(moving[0]),
                            four_digits(moving[1]), four_digits(moving[2]));
}

namespace {

bool depends_on_process_noise(const Verdict& verdict) {
  return std::ranges::any_of(verdict.reasons(),
                             [](const Reason& reason) { return reason.code == "process_noise_decides"; });
}

}  // namespace

std::string console_first_answer(const Study& study, const StudyResults& results) {
  const auto& outcome = *results.estimation;
  return fmt::format("First answer, after {:.1f} s: second thoughts follow\n{}\n", outcome.first_answer_seconds,
                     to_text(parameter_table(study, outcome)));
}

std::string console_report(const Study& study, const StudyResults& results) {
  std::string text;
  for (const auto& elements : study.structure->finite_elements) {
    text += fmt::format("'{}': {} degrees of freedom, {}", elements.part->name, elements.part->full.size(),
                        mass_text(*elements.part));
    if (elements.reduced)
      text += fmt::format("; reduced to {} ({} of the boundary, {})", elements.reduced->model.size(),
                          elements.reduced->boundary.size(), elements.reduced->error_indicators.reason);
    text += "\n";
  }
  if (!study.structure->finite_elements.empty())
    text += fmt::format("read, assembled and reduced in {:.1f} s\n\n", study.reduce_seconds);
  if (results.placement) text += console_placement(*results.placement);
  if (results.statics) text += console_statics(*study.statics, *results.statics);
  if (results.frequency_response) text += console_frequency_responses(*results.frequency_response);
  if (!results.simulation && !results.estimation && !results.placement && !results.inference && !results.statics &&
      !results.frequency_response)
    text += console_modes(study, results);
  if (results.simulation) {
    const auto& reference = results.simulation->reference;
    const double solve_error = reference.simulation.solve_error;
    const bool of_superelements = std::ranges::any_of(study.structure->finite_elements,
                                                      [](const auto& each) { return each.reference != nullptr; });
    text += fmt::format(
        "Simulation: {} degrees of freedom{}, {} s at {} Hz, {} steps per sample{} ({}{}), {:.1f} s\n\n",
        study.model->system().size(), of_superelements ? " (superelements)" : "",
        four_digits(study.simulation->duration), four_digits(study.sample_rate()), reference.substeps,
        reference.extrapolations > 0 ? " and extrapolated" : "",
        study.simulation->has_fixed_step() ? "a fixed step" : "last change " + per_cent(reference.last_change),
        solve_error > 0.0 ? fmt::format(", steps solved in single precision to {:.0e}", solve_error) : "",
        results.simulation->seconds);
  }
  if (const auto words = record_words(study, results); !words.empty()) text += words + "\n";
  if (results.updating) text += console_updating(study, results);
  if (results.estimation) {
    const auto& outcome = *results.estimation;
    const auto& time = outcome.result.time;
    const auto samples = static_cast<double>(outcome.measurements.samples());
    if (outcome.has_samples())
      text += (outcome.result.failure ? fmt::format("Parameters at {} s, before the filter stopped\n",
                                                    four_digits(outcome.measurements.end()))
                                      : std::string("Estimated parameters\n")) +
              to_text(parameter_table(study, outcome)) + "\n";
    if (outcome.has_samples() && !outcome.inputs.empty()) {
      text += "Unknown excitations\n" + to_text(input_table(outcome)) + "\n";
      if (const auto words = hardly_known_words(outcome); !words.empty()) text += words + "\n\n";
    }
    if (std::isfinite(outcome.consistency.mean_nis))
      text +=
          fmt::format("NIS {:.2f} (expected {:.2f}); {} of samples in the 95 % band\n", outcome.consistency.mean_nis,
                      outcome.consistency.expected_nis, per_cent(outcome.consistency.fraction_in_95));
    if (outcome.result.noise) text += adaptive_noise_words(outcome);
    if (outcome.frequencies)
      text += "\nNatural frequencies over the record [Hz]\n" + to_text(frequencies_table(*outcome.frequencies)) + "\n";
    if (depends_on_process_noise(results.verdict))
      text += "\nEstimates against the process noise\n" + to_text(process_noise_table(outcome)) + "\n";
    for (const auto& event : outcome.events) text += sentence(event.text);
    if (!outcome.events.empty()) text += "\n";
    if (!outcome.has_samples())
      text += fmt::format("Filter {}: it stopped before it computed a sample\n\n", to_string(outcome.filter));
    else
      text += fmt::format(
          "{} states, {} steps, {:.2g} us per step: {}\nFilter {}: {}\n{}\n", outcome.augmented_model->layout().size(),
          outcome.measurements.samples(), 1e6 * time.filter() / samples,
          speed_in_words(samples / outcome.measurements.sample_rate / time.filter()), to_string(outcome.filter),
          outcome.filter_reason,
          sentence(substep_words(outcome)) + (outcome.start.moving ? sentence(explain(outcome.start)) : "") +
              linearisation_words(outcome));
    if (const auto table = error_table("", study, outcome.points, outcome.settled); !table.rows.empty())
      text += fmt::format("Estimated motion, NRMSE after {} s{}\n", four_digits(outcome.judged_from()),
                          band_words(outcome)) +
              to_text(table) + "\n";
    if (const auto table = error_table("", study, outcome.smoothed_points, outcome.settled); !table.rows.empty())
      text += fmt::format("Motion smoothed over the whole record, NRMSE after {} s{}\n",
                          four_digits(outcome.judged_from()), band_words(outcome)) +
              to_text(table) + "\n";
    if (!outcome.open_loop_failure.empty()) text += "No open-loop comparison: " + outcome.open_loop_failure + "\n\n";
    if (outcome.open_loop)
      text += "Open-loop simulation from the estimated parameters and initial state\n" +
              to_text(open_loop_table(outcome)) + "\n";
  }
  if (results.inference) text += console_inference(*results.inference);
  if (results.validation) {
    text += validation_words(study, *results.validation) + "\n";
    if (results.validation->held_back.failure.empty()) text += to_text(validation_table(*results.validation));
    text += "\n";
  }
  if (results.prediction)
    if (const auto table = error_table("", study, results.prediction->points, results.estimation->settled);
        !table.rows.empty())
      text += "'" + results.prediction->substructure + "' driven by its estimated boundary motion, NRMSE" +
              band_words(*results.estimation) + "\n" + to_text(table) + "\n";
  if (!results.modifications.empty())
    text +=
        "Natural frequencies after modifications [Hz]\n" + to_text(modification_table(results.modifications)) + "\n";
  if (!results.modifications.empty() && results.updating) text += std::string(deviations_leave_out) + "\n";
  return text;
}

namespace {

constexpr double smallest_part = 1e-6;

}  // namespace

RestingPoints::RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled) : settled_(settled) {
  for (const auto& point : points) {
    double& largest = largest_[point.quantity];
    largest = std::max(largest, moved(point));
  }
}

bool RestingPoints::rests(const PointQuantity& point) const {
  const auto largest = largest_.find(point.quantity);
  return point.truth.size() > 0 && largest != largest_.end() && moved(point) <= smallest_part * largest->second;
}

double RestingPoints::moved(const PointQuantity& point) const {
  return rms(point.truth.tail(std::max<Eigen::Index>(0, point.truth.size() - settled_)));
}

}  // namespace kalfem
