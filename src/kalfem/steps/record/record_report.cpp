// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/record/record_report.hpp"

#include <fmt/format.h>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

/// What the filter added to a sensor's channel, with its standard deviation; nothing where it estimated none.
struct Estimate {
  double value, deviation;
};
std::optional<Estimate> estimated_rest(const EstimationOutcome& outcome, const std::string& sensor) {
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  const Index last = outcome.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index output : unknowns[i].sensors)
      if (outcome.measurements.channels[static_cast<std::size_t>(output)].name == sensor)
        return Estimate{outcome.result.unknowns.mean(static_cast<Index>(i), last),
                        outcome.result.unknowns.deviation(static_cast<Index>(i), last)};
  return std::nullopt;
}

}  // namespace

std::vector<RestFound> rest_positions(const Study& study, const StudyResults& results) {
  std::vector<RestFound> positions;
  if (!study.record || !study.record->free_response) return positions;
  const auto& found = *study.record->free_response;
  for (std::size_t j = 0; j < study.sensors.size(); ++j) {
    const auto channel = static_cast<Index>(j);
    RestFound rest{study.sensors[j].name, study.sensors[j].unit, found.position[channel], {}};
    if (found.rest_is_unknown()) {
      const auto* estimation = results.find<EstimationOutcome>();
      const auto estimate = estimation ? estimated_rest(*estimation, rest.sensor) : std::nullopt;
      rest.position += estimate ? estimate->value : 0.0;
      rest.deviation = estimate ? estimate->deviation : found.deviation[channel];
    }
    positions.push_back(rest);
  }
  return positions;
}

Json record_summary(const Study& study, const StudyResults& results) {
  const auto& [record, preparation, free_response, began] = *study.record;
  Json summary = {{"start_s", number(record.start)},
                  {"end_s", number(record.end())},
                  {"samples", record.samples()},
                  {"samples_used", record.samples_used()},
                  {"sample_rate_hz", number(record.sample_rate)}};
  if (!preparation.empty()) summary["preparation"] = preparation;
  if (!free_response) return summary;
  summary["release_s"] = number(free_response->release);
  summary["rest_s"] = number(free_response->rest);
  Json positions = Json::object();
  for (const auto& rest : rest_positions(study, results))
    positions[rest.sensor] = {
        {"position", number(rest.position)}, {"std", number(rest.deviation)}, {"unit", rest.unit}};
  summary["rest_positions"] = positions;
  return summary;
}

std::string record_words(const Study& study, const StudyResults& results) {
  if (!study.record) return "";
  const auto& [record, preparation, free_response, began] = *study.record;
  std::string text = fmt::format("Record: {} samples at {} Hz, {} s to {} s\n", record.samples(),
                                 four_digits(record.sample_rate), four_digits(record.start), four_digits(record.end()));
  for (const auto& step : preparation) text += step + (step.ends_with('\n') ? "" : "\n");
  for (const auto& rest : rest_positions(study, results))
    text += fmt::format("  {} rests at {} {}{}\n", rest.sensor, four_digits(rest.position), rest.unit,
                        rest.deviation ? fmt::format(" +- {} {}{}", four_digits(*rest.deviation), rest.unit,
                                                     results.has<EstimationOutcome>() ? "" : ", not yet estimated")
                                       : "");
  return text;
}

}  // namespace kalfem
