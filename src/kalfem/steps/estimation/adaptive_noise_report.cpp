// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

namespace {

/// One noise over the samples that were computed.
struct AdaptedNoise {
  std::string name, unit;
  double stated = 0.0;
  VectorXd course;
  Index settled = 0;
  bool of_process = false;

  [[nodiscard]] double last() const { return course[course.size() - 1]; }
  [[nodiscard]] double least() const { return course.tail(course.size() - settled).minCoeff(); }
  [[nodiscard]] double greatest() const { return course.tail(course.size() - settled).maxCoeff(); }
};

std::vector<AdaptedNoise> adapted_noises(const RecordEstimate& estimate) {
  const auto& noise = *estimate.result.noise;
  const auto& failure = estimate.result.failure;
  const Index samples = failure ? failure->computed : noise.sensors.cols();
  std::vector<AdaptedNoise> all;
  if (samples == 0) return all;
  const Index settled = std::min(estimate.settled, samples - 1);
  for (std::size_t i = 0; noise.sensors_adapt && i < estimate.measurements.channels.size(); ++i) {
    const auto& channel = estimate.measurements.channels[i];
    all.push_back({channel.name, channel.unit, channel.noise,
                   noise.sensors.row(static_cast<Index>(i)).head(samples).transpose(), settled});
  }
  if (noise.process_factor.size() > 0)
    all.push_back({"process noise", "m/s^2/sqrt(Hz)", noise.density_is_stated ? noise.density : 0.0,
                   noise.density * noise.process_factor.head(samples).cwiseSqrt(), settled, true});
  return all;
}

Json summary_of(const AdaptedNoise& noise) {
  return {{"unit", noise.unit},
          {"stated", number(noise.stated)},
          {"last", number(noise.last())},
          {"range", {number(noise.least()), number(noise.greatest())}}};
}

}  // namespace

Json adaptive_noise_summary(const RecordEstimate& estimate) {
  Json summary = Json::object();
  for (const auto& noise : adapted_noises(estimate))
    (noise.of_process ? summary["process"] : summary["sensors"][noise.name]) = summary_of(noise);
  return summary;
}

std::string adaptive_noise_words(const RecordEstimate& estimate) {
  std::string text;
  for (const auto& noise : adapted_noises(estimate))
    text +=
        fmt::format("{}: {} {} at the end, {} to {} over the record (stated {})\n",
                    noise.of_process ? "Process noise" : "Noise of " + noise.name, four_digits(noise.last()),
                    noise.unit, four_digits(noise.least()), four_digits(noise.greatest()), four_digits(noise.stated));
  return text;
}

Section adaptive_noise_section(const RecordEstimate& estimate) {
  Section section{"Adapted noise",
                  "Standard deviations that the filter found from its innovations, each sample with what was learned "
                  "before it. A model that misses part of the motion shows here as noise above its stated value.",
                  {}};
  for (const auto& noise : adapted_noises(estimate)) {
    VectorXd time(noise.course.size());
    for (Index k = 0; k < time.size(); ++k) time[k] = estimate.measurements.time(k);
    std::string id = "noise-" + noise.name;
    std::ranges::replace(id, ' ', '-');
    section.items.emplace_back(
        Chart{.id = id,
              .title = noise.name,
              .x_label = "time [s]",
              .y_label = fmt::format("noise [{}]", noise.unit),
              .x = series_values(time),
              .series = {{.label = "adapted", .y = series_values(noise.course), .role = Role::estimate},
                         {.label = "stated", .y = series_values(VectorXd::Constant(time.size(), noise.stated))}},
              .half_width = true});
  }
  return section;
}

}  // namespace kalfem
