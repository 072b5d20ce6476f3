// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/model_check_section.hpp"
#include "kalfem/report/record_check.hpp"
#include "kalfem/steps/inference/compute.hpp"
#include "kalfem/steps/modes/compute.hpp"
#include "kalfem/steps/record/record_expectation.hpp"
#include "kalfem/steps/record/record_report.hpp"
#include "kalfem/steps/updating/compute.hpp"
#include "kalfem/steps/validation/report.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

Table substructure_table(const Study& study) {
  Table table{"", {"substructure", "degrees of freedom", "mass", "lowest frequencies [Hz]"}, {}, {}};
  for (const auto& part : substructure_modes(study, study.report.modes)) {
    std::string frequencies;
    for (Eigen::Index i = 0; i < std::min<Eigen::Index>(5, part.frequencies.size()); ++i)
      frequencies += (i ? ", " : "") + four_digits(part.frequencies[i]);
    table.rows.push_back({part.name, std::to_string(part.dofs), four_digits(part.mass), frequencies});
  }
  return table;
}

Table connector_table(const Study& study) {
  Table table{"", {"connector", "law", "parameters"}, {}, {}};
  for (const auto& connector : study.model->system().connectors) {
    std::string parameters;
    const auto& quantities = connector.law->parameters();
    for (std::size_t i = 0; i < quantities.size(); ++i)
      parameters += fmt::format("{}{} = {} {}", i ? ", " : "", quantities[i].name,
                                four_digits(connector.parameters[static_cast<Eigen::Index>(i)]), quantities[i].unit);
    table.rows.push_back({connector.name, connector.law->name(), parameters});
  }
  return table;
}

Table sensor_table(const Study& study) {
  Table table{"", {"sensor", "unit", "noise", "chain states"}, {}, {}};
  for (const auto& sensor : study.sensors)
    table.rows.push_back({sensor.name, sensor.unit,
                          sensor.relative_noise ? fmt::format("{} % of rms", four_digits(100.0 * sensor.noise))
                                                : four_digits(sensor.noise),
                          std::to_string(sensor.chain.states())});
  return table;
}

Table unknown_table(const AugmentedModelSetup& setup) {
  Table table{"", {"unknown", "unit", "initial", "std", "truth"}, {}, {}};
  for (std::size_t i = 0; i < setup.options.unknowns.size(); ++i) {
    const auto& unknown = setup.options.unknowns[i];
    table.rows.push_back({unknown.name, unknown.unit, four_digits(unknown.initial), four_digits(unknown.deviation),
                          setup.true_parameters[i] ? four_digits(*setup.true_parameters[i]) : "-"});
  }
  return table;
}

Table updating_table(const UpdatingSetup& setup) {
  Table table{"", {"updated", "unit", "initial", "lower", "upper", "prior std"}, {}, {}};
  for (const auto& each : setup.parameters)
    table.rows.push_back({each.name, each.unit, four_digits(each.initial), four_digits(each.lower),
                          four_digits(each.upper), std::isfinite(each.deviation) ? four_digits(each.deviation) : "-"});
  return table;
}

void print_table(const Table& table) {
  if (!table.rows.empty()) print_report(to_text(table) + "\n");
}

/// The record by itself and beside the model; nothing without a measured record.
std::optional<RecordCheck> checked_record(const Study& study) {
  if (!study.record) return std::nullopt;
  auto check = check_record(study, expectation_of_record(study));
  print("{}\n", record_words(study, {}));
  print("{}\n", check.table.title);
  print_table(check.table);
  for (const auto& finding : check.findings) print("{}\n", finding);
  if (!check.findings.empty()) print("\n");
  return check;
}

/// Unknowns of the estimation that its sensors cannot tell apart, or not at all.
void print_indistinguishable(const Study& study) {
  const auto found = told_by_sensors(study);
  if (found && std::ranges::any_of(found->combinations, [](const auto& each) { return !each.determined; }))
    print("Before the run, by simulations about the initial values: {}\n\n", found->text);
}

/// What the record can tell of the parameters that the case infers, before it is run.
void print_identifiability(const Study& study) {
  if (!study.inference) return print_indistinguishable(study);
  const auto found = identifiability_before(study);
  if (found) print("Before the run, from the expected record: {}\n\n", found->text);
}

/// What a check found, for its last line.
struct Found {
  std::ptrdiff_t errors = 0, warnings = 0, questions = 0, remarks = 0;

  void add(const std::vector<ModelFinding>& findings) {
    errors += std::ranges::count(findings, FindingSeverity::error, &ModelFinding::severity);
    warnings += std::ranges::count(findings, FindingSeverity::warning, &ModelFinding::severity);
  }
  void add(const RecordCheck& record) {
    const auto asks = [](const std::string& finding) { return finding.ends_with('?'); };
    questions += std::ranges::count_if(record.findings, asks);
    remarks = std::ssize(record.findings) - questions;
  }
  /// "1 error, 2 warnings"
  [[nodiscard]] std::string words() const {
    std::string all;
    for (const auto& [count, one] : {std::pair{errors, "error"}, std::pair{warnings, "warning"},
                                     std::pair{questions, "question"}, std::pair{remarks, "remark"}})
      if (count > 0) all += fmt::format("{}{} {}{}", all.empty() ? "" : ", ", count, one, count == 1 ? "" : "s");
    return all.empty() ? "No problem found" : all;
  }
};

void check_parts(const Study& study, const std::optional<RecordCheck>& record, const std::string& page_file,
                 Found& found) {
  Page page{.title = study.title.empty() ? "kalfem" : study.title,
            .subtitle = "Check of the case",
            .status = VerdictState::consistent,
            .summary = "The case can be run.",
            .sections = {}};
  if (record) {
    std::string findings;
    for (const auto& finding : record->findings) findings += (findings.empty() ? "" : "\n\n") + finding;
    page.sections.push_back({.heading = "Record", .text = findings, .items = {record->table}});
  }
  for (std::size_t i = 0; i < study.structure->finite_elements.size(); ++i) {
    const auto& part = *study.structure->finite_elements[i].part;
    const auto& notes = study.element_notes[i].notes;
    const bool only_statics = study.statics && study.statics->part->name == part.name;
    const ModelCheckReport report = model_check_of(part, {.needs_mass = !only_statics});
    const Table places = places_table(part), gauges = gauges_table(part);
    found.add(report.findings);
    print("Substructure '{}'\n\n{}", part.name, model_check_text(report, notes));
    for (const Table* table : {&places, &gauges})
      if (!table->rows.empty()) print("{}\n{}\n", table->title, to_text(*table));
    page.sections.push_back(model_check_section(part.name, part.elements, report, notes));
    for (const Table* table : {&places, &gauges})
      if (!table->rows.empty()) page.sections.back().items.emplace_back(*table);
  }
  if (!page_file.empty()) write_file_atomically(page_file, render_html(page));
}

}  // namespace

ExitCode check(const std::string& case_file, const std::vector<std::string>& changes, const std::string& page_file) {
  if (!page_file.empty()) require_writable(page_file);
  const Study study = load_study(case_file, changes_of(changes));
  if (study.updating) check_first_values(study);
  print("{}\n\n", study.title.empty() ? case_file : study.title);
  print_table(substructure_table(study));
  print_table(connector_table(study));
  print_table(sensor_table(study));
  const auto record = checked_record(study);
  if (study.validation) print("{}\n\n", validation_part_words(*study.validation));
  if (study.augmented_model) print_table(unknown_table(*study.augmented_model));
  if (study.updating) print_table(updating_table(*study.updating));
  print_identifiability(study);
  Found found{.warnings = std::ssize(study.warnings)};
  if (record) found.add(*record);
  check_parts(study, record, page_file, found);
  for (const auto& warning : study.warnings) print_error("warning: {}\n", warning);
  print("{}. Nothing was run.\n", found.words());
  return done;
}

}  // namespace kalfem::command
