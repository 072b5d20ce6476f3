// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/study_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "kalfem/base/version.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/data_files.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/record/record_report.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"

// How the results came about: what was read, how it was prepared, what the filter was and why, how long it took, and
// the case with all its defaults.

namespace kalfem {
namespace {

using Eigen::Index;

std::string size_in_words(std::uintmax_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (value < 1e3) return fmt::format("{} B", bytes);
  return value < 1e6 ? fmt::format("{:.1f} kB", value / 1e3) : fmt::format("{:.1f} MB", value / 1e6);
}

Table files_table(const Study& study) {
  Table table{.title = "Data that were read", .columns = {"file", "size", "SHA-256"}};
  for (const auto& file : data_files(study))
    table.rows.push_back(
        {file.path.string(), size_in_words(file.bytes), file.sha256.empty() ? "not readable any more" : file.sha256});
  return table;
}

Table noise_table(const EstimationOutcome& outcome) {
  Table table{.title = "Noise that the filter assumed", .columns = {"sensor", "standard deviation", "of the signal"}};
  for (Index j = 0; j < outcome.measurements.values.rows(); ++j) {
    const auto& channel = outcome.measurements.channels[static_cast<std::size_t>(j)];
    const double rms = rms_of_present(outcome.measurements.values.row(j).transpose());
    const DisplayUnit shown(channel.unit, {channel.noise});
    table.rows.push_back({channel.name, shown.value(channel.noise) + " " + shown.unit(),
                          rms > 0.0 ? per_cent(channel.noise / rms) : "-"});
  }
  return table;
}

/// What was computed, by which method and why.
Table method_table(const Study& study, const StudyResults& results) {
  Table table{.title = "Method", .columns = {"", "how"}, .alignment = {Align::left, Align::left}};
  const auto add = [&](const std::string& what, const std::string& how) {
    if (!how.empty()) table.rows.push_back({what, how});
  };
  for (const auto& elements : study.structure->finite_elements)
    if (elements.reduced)
      add("reduction of '" + elements.part->name + "'",
          fmt::format("{} to {} coordinates; {}", elements.part->full.size(), elements.reduced->model.size(),
                      elements.reduced->error_indicators.reason));
  if (study.excitation_band)
    add("band of the excitation",
        fmt::format("{} to {} Hz", four_digits(study.excitation_band->from), four_digits(study.excitation_band->to)));
  if (results.has<SimulationOutcome>()) add("reference", "simulated; its sensors carry the noise that the case states");
  if (const auto* estimation = results.find<EstimationOutcome>(); estimation && estimation->has_samples()) {
    const auto& outcome = *estimation;
    add("filter", to_string(outcome.filter) + ": " + outcome.filter_reason);
    add("states", fmt::format("{}, of these {} unknown parameters", outcome.augmented_model->layout().size(),
                              outcome.augmented_model->layout().unknowns));
    add("substeps", substep_words(outcome));
    if (outcome.start.moving) add("start", explain(outcome.start));
    add("settling", fmt::format("errors and consistency count from {} s on",
                                four_digits(outcome.measurements.time(outcome.settled))));
  }
  if (const auto* updating = results.find<UpdatingOutcome>())
    add("updating", fmt::format("{}; {}", updating->method, updating->termination));
  if (const auto* inference = results.find<InferenceOutcome>())
    add("inference", inference->method + "; " + inference->likelihood);
  return table;
}

Table version_table() {
  return {.title = "Versions",
          .columns = {"part", "version"},
          .rows = {{"kalfem", version},
                   {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
                   {"compiler", __VERSION__}},
          .alignment = {Align::left, Align::left},
          .half_width = true};
}

}  // namespace

Section provenance_section(const Study& study, const StudyResults& results) {
  Section section{"How it was done", record_words(study, results), {}};
  for (auto table : {files_table(study), method_table(study, results)})
    if (!table.rows.empty()) section.items.emplace_back(std::move(table));
  if (const auto* estimation = results.find<EstimationOutcome>(); estimation && estimation->has_samples())
    section.items.emplace_back(noise_table(*estimation));
  Table timing = timing_table(study, results);
  timing.half_width = true;
  section.items.emplace_back(std::move(timing));
  section.items.emplace_back(version_table());
  section.items.emplace_back(Listing{"The case with all its defaults", study.resolved_case});
  return section;
}

}  // namespace kalfem
