// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/report/case_edit.hpp"
#include "kalfem/report/study_page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"

// What the verdict doubts and keys of the case would mend, as lines of the case file.

namespace kalfem {
namespace {

using Eigen::Index;

/// "0.16 mm" in the digits of an edit.
std::string edited(double value, const std::string& unit) {
  const DisplayUnit shown(unit, {value});
  return fmt::format("{} {}", shown.value(value, std::abs(value)), shown.unit());
}

/// Noise of a sensor at which its innovations are as large as expected: `ratio` is their rms after settling in expected
/// deviations.
std::optional<double> consistent_noise(const EstimationOutcome& outcome, Index row) {
  const Index count = outcome.result.innovation.cols() - outcome.settled;
  if (count < 2) return std::nullopt;
  const auto e = (outcome.result.innovation.row(row).tail(count).array() /
                  outcome.result.innovation_deviation.row(row).tail(count).array())
                     .eval();
  const auto there = e.isFinite();
  const double ratio = std::sqrt(there.select(e.square(), 0.0).sum() / static_cast<double>(there.count()));
  const double noise = outcome.measurements.channels[static_cast<std::size_t>(row)].noise * ratio;
  return std::isfinite(noise) && noise > 0.0 ? std::optional(noise) : std::nullopt;
}

/// Sensors whose noise is as large as what the model leaves over. Where another cause was found, innovations that are
/// too large are its effect.
std::vector<std::string> noise_lines(const StudyResults& results, const EstimationOutcome& estimation, bool has_cause) {
  const auto& channels = estimation.measurements.channels;
  std::vector<std::string> lines;
  for (const auto& reason : results.verdict.reasons()) {
    if (reason.code != "noise_too_large" && (has_cause || reason.code != "innovation_large")) continue;
    const auto channel = std::ranges::find(channels, reason.subject, &Channel::name);
    if (channel == channels.end()) continue;
    if (const auto noise = consistent_noise(estimation, static_cast<Index>(channel - channels.begin())))
      lines.push_back(fmt::format("{}: {{noise: {}}}", channel->name, edited(*noise, channel->unit)));
  }
  return lines;
}

/// "body.3.mass: {initial: 1 kg, std: 0.1 kg}" of the edits of a proposed case.
std::vector<std::string> freed_lines(const ProposedCase& proposed) {
  constexpr std::string_view section = "estimate.unknown.";
  std::vector<std::string> lines;
  for (const auto& edit : proposed.edits)
    if (edit.starts_with(section)) lines.push_back(edit.substr(section.size()));
  return lines;
}

}  // namespace

std::optional<Listing> asked_edit(const Study& study, const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  if (!estimation || results.verdict.reasons().empty()) return std::nullopt;
  const auto causes = estimation->diagnosis ? estimation->diagnosis->causes() : std::vector<TestedHypothesis>{};
  CaseEdit edit;
  for (const auto& cause : causes) edit.add(edit_against(cause, study, *estimation));
  std::string caption = causes.empty()       ? ""
                        : causes.size() == 1 ? "Undoes the mistake that explains the record best."
                                             : "Undoes the two mistakes that explain the record best.";
  if (results.proposed) {
    const auto freed = freed_lines(*results.proposed);
    edit.unknowns.insert(edit.unknowns.end(), freed.begin(), freed.end());
    caption = "case.proposed.yaml is the whole case with these unknowns: the record asks for them.";
  }
  if (estimation->has_samples() && (causes.empty() || causes.front().code != "sensor_noise"))
    if (const auto noise = noise_lines(results, *estimation, !edit.empty()); !noise.empty()) {
      edit.sensors.insert(edit.sensors.end(), noise.begin(), noise.end());
      caption += std::string(caption.empty() ? "" : " ") +
                 "Noise as large as what the model leaves over: change it in the case, or its model where the noise is "
                 "known better.";
    }
  if (edit.empty()) return std::nullopt;
  return Listing{.title = "The edit that the verdict asks for",
                 .text = edit.yaml(),
                 .folded = false,
                 .caption = std::move(caption)};
}

}  // namespace kalfem
