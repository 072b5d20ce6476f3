// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "kalfem/page/json_number.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/identified_parameters.hpp"

namespace kalfem {

using Json = nlohmann::ordered_json;

namespace {

std::string values_in_words(const Study& study, const EstimationOutcome& outcome) {
  std::string words;
  for (const auto& each : identified_unknowns(study, outcome))
    words += (words.empty() ? "" : ", ") + each.name + " " + value_in_words(each);
  return words;
}

}  // namespace

Json alternatives_summary(const Study& study, const EstimationOutcome& outcome) {
  Json all = Json::object();
  for (std::size_t i = 0; i < outcome.alternatives.size(); ++i) {
    const auto& alternative = study.alternatives[i];
    const auto& other = *outcome.alternatives[i];
    Json& own = all[alternative.name] = {{"law", alternative.law}, {"weight", number(other.weight)}};
    if (const auto failure = other.failure(); !failure.empty()) {
      own["failure"] = failure;
      continue;
    }
    own["log_evidence"] = number(other.log_evidence);
    own["parameters"] = parameters_summary(*alternative.study, other);
  }
  return all;
}

Table alternatives_table(const Study& study, const EstimationOutcome& outcome) {
  Table table{"", {"law", "ln evidence", "weight", "unknowns"}, {}, {}};
  const auto add = [&](const std::string& name, const Study& of, const EstimationOutcome& found) {
    const auto failure = found.failure();
    table.rows.push_back({name, failure.empty() ? fmt::format("{:.2f}", found.log_evidence) : "-",
                          fmt::format("{:.3g} %", 100.0 * found.weight),
                          failure.empty() ? values_in_words(of, found) : failure});
  };
  add("as given", study, outcome);
  for (std::size_t i = 0; i < outcome.alternatives.size(); ++i)
    add(study.alternatives[i].name, *study.alternatives[i].study, *outcome.alternatives[i]);
  return table;
}

std::string unlikely_law_words(const Study& study, const EstimationOutcome& outcome) {
  constexpr double hardly = 0.05;
  if (outcome.alternatives.empty() || outcome.weight >= hardly) return "";
  std::size_t best = 0;
  for (std::size_t i = 1; i < outcome.alternatives.size(); ++i)
    if (outcome.alternatives[i]->weight > outcome.alternatives[best]->weight) best = i;
  return fmt::format(
      "estimate.alternatives: the law of the case has {:.2g} % of the evidence, '{}' has {:.3g} %; motions and forces "
      "follow it, parameters and verdict are those of the case's law: give it the law '{}'",
      100.0 * outcome.weight, study.alternatives[best].name, 100.0 * outcome.alternatives[best]->weight,
      study.alternatives[best].name);
}

Section alternatives_section(const Study& study, const EstimationOutcome& outcome) {
  return {"Laws, by the evidence of the record",
          "Each law was estimated by itself. Its weight is its probability, all being as probable before. Motions and "
          "forces are the mixture of all: their bands hold the spread between the laws.",
          {alternatives_table(study, outcome)}};
}

}  // namespace kalfem
