// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"

// Whether the estimation agrees with its record: innovations, the record simulated from the estimates, events in it,
// and the inputs that were estimated with it.

namespace kalfem {
namespace {

using Eigen::Index;

/// Mean of NIS over windows of about a hundredth of the record, with the 95 % band of such a mean.
Chart nis_chart(const EstimationOutcome& outcome) {
  const Index samples = outcome.result.nis.size(), window = std::max<Index>(1, samples / 100);
  Chart chart{.id = "nis", .title = "Normalised innovation squared", .x_label = "time [s]", .y_label = "mean NIS [-]"};
  Series mean{.label = fmt::format("mean of {} samples", window), .y = {}, .role = Role::estimate};
  Series expected{.label = "expected, with 95 % band", .y = {}, .role = Role::limit};
  for (Index begin = 0; begin + window <= samples; begin += window) {
    double sum = 0.0, degrees = 0.0, count = 0.0;
    for (Index k = begin; k < begin + window; ++k)
      if (std::isfinite(outcome.result.nis[k]))
        sum += outcome.result.nis[k], degrees += outcome.result.measured[k], count += 1.0;
    if (count == 0.0) continue;
    chart.x.push_back(outcome.measurements.time(begin + window / 2));
    mean.y.push_back(sum / count);
    expected.y.push_back(degrees / count);
    expected.lower.push_back(chi_squared_quantile(0.025, degrees) / count);
    expected.upper.push_back(chi_squared_quantile(0.975, degrees) / count);
  }
  chart.series = {mean, expected};
  return chart;
}

}  // namespace

Section inputs_section(const EstimationOutcome& outcome) {
  Section section{"Unknown excitations",
                  "Estimated from the sensors alone, with their 95 % bands. " + hardly_known_words(outcome),
                  {input_table(outcome)}};
  for (const auto& input : outcome.inputs) {
    Chart chart{.id = "input-" + input.input.name,
                .title = input.input.name,
                .caption = input.nrmse ? "NRMSE " + per_cent(*input.nrmse) + "." : "",
                .x_label = "time [s]",
                .y_label = input.input.name + " [" + input.input.unit + "]",
                .x = times(outcome.measurements),
                .series = {with_band("estimate", input.mean, input.deviation, Role::estimate)}};
    if (input.truth.size() > 0)
      chart.series.push_back({.label = "true", .y = series_values(input.truth), .role = Role::truth});
    section.items.emplace_back(std::move(chart));
  }
  return section;
}

Section consistency_section(const EstimationOutcome& outcome) {
  Section section{"Consistency", "", {}};
  if (std::isfinite(outcome.consistency.mean_nis)) {
    section.text = fmt::format("Mean NIS {:.3f} (expected {:.3f}); {:.1f} % of the samples are in the 95 % band.",
                               outcome.consistency.mean_nis, outcome.consistency.expected_nis,
                               100.0 * outcome.consistency.fraction_in_95);
    section.items.emplace_back(nis_chart(outcome));
  }
  section.text += "\n\nThe filter takes " + substep_words(outcome) + "." +
                  (outcome.start.moving ? "\n\nAt the start, " + explain(outcome.start) + "." : "");
  return section;
}

Section open_loop_section(const EstimationOutcome& outcome) {
  Section section{"Open-loop simulation of the record",
                  "Simulated from the estimated parameters and initial state, without correction by measurements.",
                  {open_loop_table(outcome)}};
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& channel = outcome.measurements.channels[i];
    section.items.emplace_back(Chart{.id = "open-loop-" + channel.name,
                                     .title = channel.name,
                                     .x_label = "time [s]",
                                     .y_label = "[" + channel.unit + "]",
                                     .x = times(outcome.measurements),
                                     .series = {{.label = "measured",
                                                 .y = series_values(outcome.measurements.values.row(row).transpose()),
                                                 .role = Role::measured},
                                                {.label = "simulated",
                                                 .y = series_values(outcome.open_loop_sensors.row(row).transpose()),
                                                 .role = Role::predicted}}});
  }
  return section;
}

Section events_section(const std::vector<SensorEvent>& events) {
  Table table{"", {"sensor or unknown", "event", "from", "to", "samples", "found"}, {}, {}};
  for (const auto& event : events)
    table.rows.push_back({event.channel.empty() ? "all" : event.channel, to_string(event.kind),
                          fmt::format("{:.6g} s", event.from), fmt::format("{:.6g} s", event.to),
                          std::to_string(event.count), event.text});
  return {"Events in the record", "", {table}};
}

}  // namespace kalfem
