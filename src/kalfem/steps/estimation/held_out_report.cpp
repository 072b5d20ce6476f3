// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"

namespace kalfem {

using Json = nlohmann::ordered_json;

namespace {

Json sensor_summary(const HeldOutSensor& sensor) {
  return {{"unit", sensor.unit},
          {"samples", sensor.samples},
          {"inside", number(sensor.inside)},
          {"motion_std", number(sensor.motion_deviation)},
          {"noise_std", number(sensor.noise)},
          {"followed_errors", number(sensor.followed)},
          {"errors_in_band", number(sensor.in_band)},
          {"motion_inside", number(sensor.motion_inside)},
          {"holds", sensor.holds()}};
}

Json sensors_summary(const std::vector<HeldOutSensor>& sensors) {
  Json all = Json::object();
  for (const auto& each : sensors) all[each.name] = sensor_summary(each);
  return all;
}

std::string percent(double share, int digits) { return fmt::format("{:.{}f} %", 100.0 * share, digits); }

Table table_of(const std::vector<HeldOutSensor>& sensors) {
  Table table{"", {"sensor", "unit", "std of its motion", "noise", "samples inside", "motion inside"}, {}, {}};
  for (const auto& each : sensors)
    table.rows.push_back({each.name, each.unit, fmt::format("{:.2g}", each.motion_deviation),
                          fmt::format("{:.2g}", each.noise), percent(each.inside, 1),
                          each.holds() ? "not contradicted" : "about " + percent(each.motion_inside, 0)});
  return table;
}

std::string trial_words(const AdaptedProcessTrial& adapted) {
  return fmt::format("With process noise that adapts, from {:.2g} m/s^2/sqrt(Hz), bands {} (log-likelihood {:+.3g}).",
                     adapted.density, adapted.mends ? "hold" : "do not hold either, or the record is no likelier",
                     adapted.gain);
}

}  // namespace

Json held_out_summary(const HeldOutStudy& study) {
  Json summary = {{"sensors", sensors_summary(study.sensors)}, {"not_tried", study.not_tried}};
  if (const auto& adapted = study.adapted)
    summary["adapted_process_noise"] = {{"acceleration", number(adapted->density)},
                                        {"log_likelihood_gain", number(adapted->gain)},
                                        {"mends", adapted->mends},
                                        {"sensors", sensors_summary(adapted->sensors)}};
  return summary;
}

std::string held_out_words(const HeldOutStudy& study) {
  std::vector<std::string> shares;
  for (const auto& each : study.sensors) shares.push_back(each.name + " " + percent(each.inside, 1));
  std::string words =
      fmt::format("Predicted from the other sensors, in their 95 % band: {} of samples\n", fmt::join(shares, ", "));
  if (study.worst()) words += to_text(table_of(study.sensors));
  if (study.adapted) words += trial_words(*study.adapted) + "\n";
  if (!study.not_tried.empty()) words += fmt::format("Not tried: {}\n", fmt::join(study.not_tried, ", "));
  return words;
}

Section held_out_section(const HeldOutStudy& study) {
  Section section{
      "Sensors held out as virtual ones",
      "Each sensor in turn was predicted from all others, as a quantity that no sensor measures is. Its band "
      "shall hold 95 % of its samples, and its errors shall not follow its motion.",
      {table_of(study.sensors)}};
  if (study.adapted) section.text += " " + trial_words(*study.adapted);
  return section;
}

}  // namespace kalfem
