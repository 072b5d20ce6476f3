// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/report/study_page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"

// The reasons for doubt that one number of the case would mend, as lines of the case file.

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

}  // namespace

std::optional<Listing> asked_edit(const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  if (!estimation || !estimation->has_samples()) return std::nullopt;
  const auto& channels = estimation->measurements.channels;
  std::string lines;
  for (const auto& reason : results.verdict.reasons()) {
    if (reason.code != "noise_too_large" && reason.code != "innovation_large") continue;
    const auto channel = std::ranges::find(channels, reason.subject, &Channel::name);
    if (channel == channels.end()) continue;
    if (const auto noise = consistent_noise(*estimation, static_cast<Index>(channel - channels.begin())))
      lines += fmt::format("  {}: {{noise: {}}}\n", channel->name, edited(*noise, channel->unit));
  }
  if (lines.empty()) return std::nullopt;
  return Listing{.title = "The edit that the verdict asks for",
                 .text = "sensors:\n" + lines,
                 .folded = false,
                 .caption =
                     "Noise as large as what the model leaves over. Change these numbers in the case, or its "
                     "model where the noise is known better."};
}

}  // namespace kalfem
