// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/correlation/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/heat_map.hpp"
#include "kalfem/steps/correlation/expanded_shapes.hpp"
#include "kalfem/steps/correlation/point_match_words.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_sensors = 6;  ///< on a terminal
constexpr double low_comac = 0.95;       ///< below it a sensor is shown there

Json rows_of(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) rows.push_back(numbers(matrix.row(i).transpose()));
  return rows;
}

Json json_of(const CorrelatedComparison& each) {
  const auto& correlation = each.correlation;
  Json pairs = Json::array(), sensors = Json::object(), mistakes = Json::array();
  for (const auto& pair : correlation.pairs)
    pairs.push_back({{"measured_hz", number(pair.measured_frequency)},
                     {"model_mode", pair.model_mode ? Json(*pair.model_mode) : Json()},
                     {"model_hz", pair.model_mode ? number(pair.model_frequency) : Json()},
                     {"error", pair.model_mode ? number(pair.relative_error) : Json()},
                     {"mac", number(pair.mac)},
                     {"complexity", number(pair.complexity)}});
  for (const auto& sensor : correlation.sensors)
    sensors[sensor.name] = {{"place", sensor.place}, {"comac", number(sensor.comac)}};
  for (const auto& mistake : correlation.mistakes)
    mistakes.push_back({{"kind", word_of(mistake.kind)},
                        {"sensors", mistake.sensors},
                        {"measures", mistake.place},
                        {"text", mistake.in_words()},
                        {"mac_before", number(mistake.mac_before)},
                        {"mac_after", number(mistake.mac_after)},
                        {"evidence", number(mistake.evidence)}});
  return {{"modes", pairs},
          {"sensors", sensors},
          {"mistakes", mistakes},
          {"model_hz", numbers(correlation.frequencies)},
          {"mac", rows_of(correlation.mac)},
          {"auto_mac", rows_of(correlation.auto_mac)},
          {"orthogonality", correlation.orthogonality.size() > 0 ? rows_of(correlation.orthogonality) : Json()},
          {"expansion", expansion_json(each)}};
}

double degrees(double angle) { return angle * 180.0 / std::numbers::pi; }

Json json_of(const std::vector<ResponseAgreement>& responses) {
  Json all = Json::array();
  for (const auto& each : responses)
    all.push_back({{"response", each.name},
                   {"frac", number(each.frac)},
                   {"model_to_measured", number(each.size)},
                   {"phase_deg", each.phase ? number(degrees(*each.phase)) : Json()}});
  return all;
}

Table agreement_table(const CorrelatedResponses& compared) {
  Table table{"Responses of '" + compared.name + "'", {"response", "FRAC", "model / measured", "phase [deg]"}, {}, {}};
  for (const auto& each : compared.responses)
    table.rows.push_back({each.name, fmt::format("{:.3f}", each.frac), fmt::format("{:.3g}", each.size),
                          each.phase ? fmt::format("{:.0f}", degrees(*each.phase)) : "-"});
  return table;
}

Picture picture(const std::string& title, const std::string& caption, const Eigen::MatrixXd& values,
                const Correlation& correlation, bool of_model) {
  HeatMap map{.name = title,
              .values = values.cwiseAbs(),
              .row_title = "measured",
              .column_title = of_model ? "model" : "measured"};
  for (const auto& pair : correlation.pairs)
    if (values.rows() == std::ssize(correlation.pairs) || pair.model_mode)
      map.rows.push_back(four_digits(pair.measured_frequency) + " Hz");
  for (Index j = 0; j < values.cols(); ++j) map.columns.push_back(std::to_string(j + 1));
  return {.title = title, .caption = caption, .svg = heat_map_svg(map), .half_width = true};
}

std::string heading(const CorrelatedComparison& each, bool updated) {
  return fmt::format("'{}' and {}'{}'", each.name, updated ? "the updated " : "", each.substructure);
}

}  // namespace

Table correlated_mode_table(const Correlation& correlation) {
  Table table{"Modes", {"measured [Hz]", "mode", "model [Hz]", "error", "MAC", "out of phase", "band"}, {}, {}};
  const auto band = [&](const PairedMode& pair) -> std::string {
    const auto& shapes = correlation.expansion.shapes;
    const auto shape = std::ranges::find(shapes, pair.measured, &ExpandedShape::measured);
    if (shape == shapes.end()) return "-";
    return shape->band > 1.0 ? "over 100 %" : fmt::format("{:.1f} %", 100.0 * shape->band);
  };
  for (const auto& pair : correlation.pairs)
    table.rows.push_back({four_digits(pair.measured_frequency),
                          pair.model_mode ? std::to_string(*pair.model_mode) : "-",
                          pair.model_mode ? four_digits(pair.model_frequency) : "-",
                          pair.model_mode ? signed_per_cent(pair.relative_error) : "-", fmt::format("{:.3f}", pair.mac),
                          pair.complexity > 0.0 ? fmt::format("{:.1f} %", 100.0 * pair.complexity) : "-", band(pair)});
  return without_empty_columns(std::move(table));
}

Table correlated_sensor_table(const Correlation& correlation, std::size_t most) {
  std::vector<SensorCorrelation> sensors = correlation.sensors;
  std::erase_if(sensors, [](const auto& sensor) { return !std::isfinite(sensor.comac); });
  std::ranges::stable_sort(sensors, {}, &SensorCorrelation::comac);
  if (sensors.size() > most) sensors.resize(most);
  Table table{"Sensors, the lowest COMAC first", {"sensor", "place", "COMAC"}, {}, {}};
  for (const auto& sensor : sensors)
    table.rows.push_back({sensor.name, sensor.place, fmt::format("{:.3f}", sensor.comac)});
  return table;
}

std::string words_of(const SetupMistake& mistake) {
  return fmt::format("{}; mended, the mean MAC rises from {:.3f} to {:.3f}", mistake.in_words(), mistake.mac_before,
                     mistake.mac_after);
}

Json correlation_summary(const CorrelationOutcome& outcome) {
  Json all = {{"updated", outcome.updated}, {"comparisons", Json::object()}};
  for (const auto& each : outcome.comparisons) all["comparisons"][each.name] = json_of(each);
  for (const auto& each : outcome.responses) all["comparisons"][each.name] = {{"responses", json_of(each.responses)}};
  return all;
}

std::string console_correlation(const CorrelationOutcome& outcome) {
  std::string text;
  for (const auto& each : outcome.comparisons) {
    const bool stands_out =
        std::ranges::any_of(each.correlation.sensors, [](const auto& sensor) { return sensor.comac < low_comac; });
    if (outcome.updated && !stands_out && each.correlation.mistakes.empty()) continue;  // the update shows its modes
    text += "Correlation of " + heading(each, outcome.updated) + "\n";
    if (!outcome.updated)
      text += to_text(correlated_mode_table(each.correlation)) + "\n" + mixing_words(each.correlation.expansion);
    if (stands_out) text += to_text(correlated_sensor_table(each.correlation, most_sensors)) + "\n";
    for (const auto& mistake : each.correlation.mistakes) text += "  " + words_of(mistake) + "\n";
    if (each.placed)
      for (const auto& contradiction : each.placed->contradictions) text += "  " + contradiction + "\n";
    if (!each.correlation.mistakes.empty()) text += "\n";
  }
  for (const auto& each : outcome.responses) {
    const auto turned = turned_ones(each.responses);
    if (outcome.updated && turned.empty()) continue;
    text += fmt::format("Correlation of the responses of '{}'\n", each.name) + to_text(agreement_table(each)) + "\n";
    for (const auto& sentence : turned) text += "  " + sentence + "\n";
  }
  return text;
}

Section correlation_section(const CorrelationOutcome& outcome) {
  Section section{.heading = "Correlation"};
  for (const auto& each : outcome.comparisons) {
    const auto& found = each.correlation;
    section.text += heading(each, outcome.updated) + ". ";
    for (const auto& mistake : found.mistakes) section.text += "Set-up: " + words_of(mistake) + ". ";
    section.items.emplace_back(correlated_mode_table(found));
    section.items.emplace_back(
        picture("MAC", "Rows: measured modes. Columns: elastic modes of the model.", found.mac, found, true));
    section.items.emplace_back(picture("AutoMAC", "Large beside the diagonal: the sensors do not tell the two apart.",
                                       found.auto_mac, found, false));
    if (found.orthogonality.size() > 0)
      section.items.emplace_back(picture("Orthogonality", "Of the paired modes, with the mass reduced to the sensors.",
                                         found.orthogonality, found, false));
    if (auto sensors = correlated_sensor_table(found, found.sensors.size()); !sensors.rows.empty())
      section.items.emplace_back(std::move(sensors));
    add_expanded_shapes(each, section);
    if (!each.placed) continue;
    section.text += "By its coordinates the test is " + fit_words(each.placed->match.fit) + ". ";
    for (const auto& contradiction : each.placed->contradictions) section.text += capitalised(contradiction) + ". ";
    section.items.emplace_back(point_match_table(each.placed->match, each.part->elements.mesh));
  }
  for (const auto& each : outcome.responses) {
    for (const auto& turned : turned_ones(each.responses)) section.text += "Set-up: " + turned + ". ";
    section.items.emplace_back(agreement_table(each));
  }
  return section;
}

}  // namespace kalfem
