// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/frequency_response/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "kalfem/formats/tables/write_frf_table.hpp"
#include "kalfem/page/frf_charts.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/frequency_response/outcome.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;
using Eigen::VectorXcd;

Json peaks_json(const std::vector<ComputedPeak>& peaks) {
  Json json = Json::array();
  for (const auto& peak : peaks)
    json.push_back({{"frequency_hz", number(peak.frequency)},
                    {"damping_ratio", number(peak.damping)},
                    {"magnitude", number(peak.magnitude)}});
  return json;
}

Json response_json(const ComputedResponse& response) {
  Json json = {{"input", response.input},
               {"output", response.output},
               {"quantity", response.quantity},
               {"unit", response.unit},
               {"peaks", peaks_json(response.peaks)}};
  if (const auto& difference = response.difference)
    json["difference"] = {{"at_resonances", number(difference->at_resonances)},
                          {"between", number(difference->between)},
                          {"between_at_hz", number(difference->between_at)}};
  return json;
}

Json cost_json(const ResponseCost& cost) { return {{"dofs", cost.dofs}, {"seconds", number(cost.seconds)}}; }

/// The largest difference of all responses, by one of its members; nothing where there is none.
std::optional<double> largest(const FrequencyResponseOutcome& outcome,
                              std::optional<double> ResponseDifference::*member) {
  std::optional<double> found;
  for (const auto& response : outcome.responses)
    if (response.difference) found = std::max(found, (*response.difference).*member);
  return found;
}

std::string percentage(const std::optional<double>& ratio) {
  return ratio ? fmt::format("{:.2g} %", 100.0 * *ratio) : "-";
}

Table peaks_table(const FrequencyResponseOutcome& outcome) {
  Table table{"Peaks", {"response", "unit", "frequency [Hz]", "damping", "magnitude"}, {}, {}};
  for (const auto& response : outcome.responses)
    for (const auto& peak : response.peaks)
      table.rows.push_back({response.quantity + " at " + response.name, response.unit, four_digits(peak.frequency),
                            peak.damping ? fmt::format("{:.3g} %", 100.0 * *peak.damping) : "-",
                            four_digits(peak.magnitude)});
  return table;
}

Table difference_table(const FrequencyResponseOutcome& outcome) {
  Table table{"Reduced against full model",
              {"response", "at resonances, of the peak", "between, of the response", "there [Hz]"},
              {},
              {}};
  for (const auto& response : outcome.responses)
    if (const auto& difference = response.difference)
      table.rows.push_back({response.quantity + " at " + response.name, percentage(difference->at_resonances),
                            percentage(difference->between),
                            difference->between ? four_digits(difference->between_at) : "-"});
  return table;
}

std::string models_in_words(const FrequencyResponseOutcome& outcome) {
  std::string text;
  for (const auto& [name, cost] : {std::pair{"full", outcome.full}, {"reduced", outcome.reduced}})
    if (cost)
      text += fmt::format("{}{} model: {} degrees of freedom, {:.1f} s", text.empty() ? "" : "; ", name, cost->dofs,
                          cost->seconds);
  return text;
}

std::vector<Table> tables_of(const FrequencyResponseOutcome& outcome) {
  std::vector<Table> tables;
  for (auto& table : {peaks_table(outcome), difference_table(outcome)})
    if (!table.rows.empty()) tables.push_back(without_empty_columns(table));
  return tables;
}

/// Writes the responses to one input, of one quantity and model.
void write_table(const std::filesystem::path& folder, const std::string& model, VectorXcd ComputedResponse::*values,
                 const Eigen::VectorXd& lines, const std::vector<const ComputedResponse*>& set) {
  FrequencyResponse table{.lines = lines, .outputs = {}, .values = {}};
  table.values.resize(lines.size(), std::ssize(set));
  for (std::size_t j = 0; j < set.size(); ++j) {
    table.outputs.push_back({set[j]->output, set[j]->unit});
    table.values.col(static_cast<Index>(j)) = set[j]->*values;
  }
  const auto& first = *set.front();
  write_frf_table(folder / fmt::format("frf_{}_{}_{}.csv", model, first.quantity, first.input), table);
}

}  // namespace

Json frequency_response_summary(const FrequencyResponseOutcome& outcome) {
  Json json = {{"from_hz", number(outcome.frequencies[0])},
               {"to_hz", number(outcome.frequencies.tail(1)[0])},
               {"lines", outcome.frequencies.size()}};
  if (outcome.full) json["full"] = cost_json(*outcome.full);
  if (outcome.reduced) json["reduced"] = cost_json(*outcome.reduced);
  json["responses"] = Json::array();
  for (const auto& response : outcome.responses) json["responses"].push_back(response_json(response));
  return json;
}

std::string frequency_response_answer(const FrequencyResponseOutcome& outcome) {
  std::string text = fmt::format("{} from {} to {} Hz", counted(std::ssize(outcome.responses), "frequency response"),
                                 four_digits(outcome.frequencies[0]), four_digits(outcome.frequencies.tail(1)[0]));
  if (const auto at = largest(outcome, &ResponseDifference::at_resonances))
    text += fmt::format("; the reduced model differs by at most {} of the peak at resonances, {} between",
                        percentage(at), percentage(largest(outcome, &ResponseDifference::between)));
  return text + ".";
}

std::string console_frequency_responses(const FrequencyResponseOutcome& outcome) {
  std::string text = frequency_response_answer(outcome) + "\n";
  for (const auto& table : tables_of(outcome)) text += "\n" + table.title + "\n" + to_text(table);
  return text + "\n" + models_in_words(outcome) + "\n\n";
}

Section frequency_response_section(const FrequencyResponseOutcome& outcome) {
  Section section{"Frequency responses", frequency_response_answer(outcome) + " " + models_in_words(outcome) + ".", {}};
  for (auto& table : tables_of(outcome)) section.items.emplace_back(std::move(table));
  for (std::size_t i = 0; i < outcome.responses.size(); ++i) {
    const auto& response = outcome.responses[i];
    const FrfChartWords words{.id = fmt::format("computed-{}", i + 1),
                              .title = response.quantity + " at " + response.name,
                              .unit = response.unit};
    std::vector<FrfSeries> series;
    if (response.full.size() > 0) series.push_back({"full", response.full, Role::truth});
    if (response.reduced.size() > 0) series.push_back({"reduced", response.reduced, Role::estimate});
    section.items.emplace_back(magnitude_chart(words, outcome.frequencies, series));
    section.items.emplace_back(phase_chart(words, outcome.frequencies, series));
  }
  return section;
}

void write_frequency_responses(const std::filesystem::path& folder, const FrequencyResponseOutcome& outcome) {
  std::map<std::pair<std::string, std::string>, std::vector<const ComputedResponse*>> sets;
  for (const auto& response : outcome.responses) sets[{response.input, response.quantity}].push_back(&response);
  for (const auto& [key, set] : sets) {
    if (outcome.full) write_table(folder, "full", &ComputedResponse::full, outcome.frequencies, set);
    if (outcome.reduced) write_table(folder, "reduced", &ComputedResponse::reduced, outcome.frequencies, set);
  }
}

}  // namespace kalfem
