// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/report.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Half the 95 % quantile of chi-squared: how far the profile falls to either end of its interval.
constexpr double profile_drop = 1.920729410347062;

bool has_finite(const VectorXd& values) { return values.array().isFinite().any(); }

std::string in_brackets(const std::string& unit) { return unit.empty() || unit == "-" ? "" : " [" + unit + "]"; }

/// Charts are found by their ids, which hold no blank.
std::string id_of(const std::string& kind, const std::string& name) {
  std::string id = kind + "-" + name;
  std::ranges::replace_if(
      id, [](char c) { return std::string(" \t\r\n\f").find(c) != std::string::npos; }, '-');
  return id;
}

/// Far below the limit nothing is of interest, so the axis ends a little below it.
Chart profile_chart(const ProfileLikelihood& profile) {
  const std::vector<double> limit(static_cast<std::size_t>(profile.values.size()), -profile_drop);
  return {.id = id_of("profile", profile.name),
          .title = "Profile likelihood of " + profile.name,
          .x_label = profile.name + in_brackets(profile.unit),
          .y_label = "ln p less its largest [-]",
          .x = series_values(profile.values),
          .series = {{.label = "profile", .y = series_values(profile.log_likelihood), .role = Role::estimate},
                     {.label = "95 % limit", .y = limit, .role = Role::limit}},
          .y_window = AxisRange{-4.0 * profile_drop, 0.3},
          .half_width = true};
}

Chart band_chart(const PredictiveBand& band) {
  Chart chart{.id = id_of("predictive", band.sensor),
              .title = "Response of " + band.sensor + " at draws of the posterior",
              .caption = std::isfinite(band.coverage)
                             ? per_cent(band.coverage) + " of the measured samples are in the 95 % band."
                             : "",
              .x_label = "time [s]",
              .y_label = band.sensor + in_brackets(band.unit),
              .series = {{.label = "measured", .y = series_values(band.measured), .role = Role::measured},
                         {.label = "mean, with 95 % band",
                          .y = series_values(band.mean),
                          .lower = series_values(band.lower),
                          .upper = series_values(band.upper),
                          .role = Role::predicted}}};
  for (Index k = 0; k < band.mean.size(); ++k)
    chart.x.push_back(band.start + static_cast<double>(k) / band.sample_rate);
  return chart;
}

/// Whether the chart can be drawn.
bool is_complete(const PredictiveBand& band) {
  const Index size = band.mean.size();
  return size > 0 && band.sample_rate > 0.0 && has_finite(band.mean) && band.measured.size() == size &&
         band.lower.size() == size && band.upper.size() == size;
}
bool is_complete(const ProfileLikelihood& profile) {
  const auto& x = profile.values;
  return x.size() > 1 && x.allFinite() && profile.log_likelihood.size() == x.size() &&
         has_finite(profile.log_likelihood) && (x.tail(x.size() - 1).array() > x.head(x.size() - 1).array()).all();
}

std::string text_of(const InferenceOutcome& outcome) {
  std::string text = inference_answer(outcome);
  const auto add = [&text](const std::string& heading, const std::string& words) {
    if (!words.empty()) text += "\n\n" + heading + words;
  };
  for (const auto& warning : inference_warnings(outcome)) add("Warning: ", warning);
  add("", inference_method_words(outcome));
  if (outcome.before) add("Expected at the prior's centre: ", outcome.before->text);
  if (outcome.after) add("", after_words(outcome));
  add("", filter_words(outcome));
  return text;
}

}  // namespace

Section inference_section(const InferenceOutcome& outcome) {
  Section section{"What the data tell of the parameters", text_of(outcome), {}};
  const auto add = [&section](Table table) {
    if (!table.rows.empty()) section.items.emplace_back(std::move(table));
  };
  add(posterior_table(outcome));
  add(mode_table(outcome));
  if (auto picture = corner_plot(outcome)) section.items.emplace_back(std::move(*picture));
  add(convergence_table(outcome));
  add(identifiability_table(outcome));
  add(filter_table(outcome));
  add(profile_table(outcome));
  for (const auto& profile : outcome.profiles)
    if (is_complete(profile)) section.items.emplace_back(profile_chart(profile));
  for (const auto& band : outcome.bands)
    if (is_complete(band)) section.items.emplace_back(band_chart(band));
  if (outcome.laws) add(law_table(*outcome.laws));
  for (const auto& each : outcome.sensitivity) add(sobol_table(outcome, each));
  return section;
}

}  // namespace kalfem
