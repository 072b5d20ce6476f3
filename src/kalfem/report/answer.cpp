// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/report/frequency_response_report.hpp"
#include "kalfem/report/identified_parameters.hpp"
#include "kalfem/report/inference_tables.hpp"
#include "kalfem/report/placement_report.hpp"
#include "kalfem/report/statics_report.hpp"
#include "kalfem/report/tables.hpp"

namespace kalfem {
namespace {

/// "4 accelerations and 1 displacement"
std::string sensors_in_words(const Study& study, const Record& record) {
  std::map<std::string, Eigen::Index> kinds;
  for (const auto& channel : record.channels) {
    const auto sensor = std::ranges::find(study.sensors, channel.name, &Sensor::name);
    if (sensor == study.sensors.end()) continue;
    switch (sensor->output.quantity) {
      case ObservedQuantity::displacement:
      case ObservedQuantity::connector_deformation:
        ++kinds["displacement"];
        break;
      case ObservedQuantity::velocity:
      case ObservedQuantity::connector_rate:
        ++kinds["velocity signal"];
        break;
      case ObservedQuantity::acceleration:
        ++kinds["acceleration"];
        break;
      case ObservedQuantity::connector_force:
        ++kinds["force"];
        break;
      case ObservedQuantity::strain:
        ++kinds["strain"];
        break;
    }
  }
  std::vector<std::string> words;
  for (const auto& [kind, count] : kinds) words.push_back(counted(count, kind));
  return fmt::format("{}", fmt::join(words, " and "));
}

/// "known to 0.3 % (mu_k1) to 2 % (mu_c1)"
std::string precision_in_words(const std::vector<IdentifiedParameter>& parameters) {
  const auto relative = [](const IdentifiedParameter& each) { return each.deviation / std::abs(each.value); };
  std::vector<const IdentifiedParameter*> known;
  for (const auto& each : parameters)
    if (std::isfinite(relative(each)) && each.deviation > 0.0) known.push_back(&each);
  if (known.empty()) return "";
  const auto [best, worst] = std::ranges::minmax_element(known, {}, [&](const auto* each) { return relative(*each); });
  const auto words = [&](const IdentifiedParameter& each) {
    const double per_cent = 100.0 * relative(each);
    return (per_cent < 10.0 ? fmt::format("{:.2g}", per_cent) : fmt::format("{:.0f}", per_cent)) + " % (" + each.name +
           ")";
  };
  return known.size() == 1 ? "standard deviation " + words(**best)
                           : "standard deviations from " + words(**best) + " to " + words(**worst);
}

/// Up to three parameters with their values, more by their number.
std::string found_in_words(const std::vector<IdentifiedParameter>& parameters) {
  constexpr std::size_t most = 3;
  if (parameters.size() > most) return counted(static_cast<Eigen::Index>(parameters.size()), "parameter");
  std::vector<std::string> words;
  for (const auto& each : parameters) words.push_back(each.name + " = " + value_in_words(each));
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string updated_in_words(const UpdatingOutcome& outcome) {
  return fmt::format("{} of the model updated: the residual decreased from {} to {} standard deviations.",
                     counted(outcome.values.size(), "parameter"), four_digits(outcome.residual_initial),
                     four_digits(outcome.residual_final));
}

std::string estimated_in_words(const Study& study, const EstimationOutcome& outcome,
                               const std::vector<IdentifiedParameter>& parameters) {
  const auto& record = outcome.measurements;
  const std::string from =
      fmt::format("from {} over {} s", sensors_in_words(study, record), four_digits(record.end() - record.start));
  if (parameters.empty()) return "The motion of the whole structure was estimated " + from + ".";
  const std::string sure = precision_in_words(parameters);
  return fmt::format("Identified {}: {}{}.", from, found_in_words(parameters), sure.empty() ? "" : "; " + sure);
}

std::string doubts_in_words(const std::vector<Reason>& reasons) {
  return fmt::format("{} for doubt, the worst: {}.",
                     reasons.size() == 1 ? "One reason" : fmt::format("{} reasons", reasons.size()),
                     reasons.front().text);
}

/// What follows from the answer.
std::string next_step(const StudyResults& results) {
  if (const auto reasons = results.verdict.reasons(); !reasons.empty())
    return reasons.front().remedy.empty() ? "" : "Next: " + reasons.front().remedy + ".";
  if (results.estimation && !results.validation && !results.simulation)
    return "Next: hold back a part of the record (`validate`) and see whether the values predict it.";
  if (results.identified) return "Next: run case.identified.yaml, which holds the values found.";
  return "";
}

}  // namespace

std::string answer(const Study& study, const StudyResults& results) {
  std::vector<std::string> sentences;
  const auto say = [&](const std::string& sentence) {
    if (!sentence.empty()) sentences.push_back(sentence);
  };
  if (!results.complete()) return results.why_unusable();
  if (results.updating) say(updated_in_words(*results.updating));
  if (results.estimation)
    say(estimated_in_words(study, *results.estimation, identified_unknowns(study, *results.estimation)));
  else if (results.inference)
    say(inference_answer(*results.inference));
  else if (results.placement)
    say(placement_answer(*results.placement));
  else if (!results.simulation && results.statics)
    say(statics_answer(*results.statics));
  else if (!results.simulation && results.frequency_response)
    say(frequency_response_answer(*results.frequency_response));
  else if (!results.updating)
    say(results.simulation ? "The simulation is complete." : "Modes computed.");
  if (results.estimation && results.inference) say(law_words(*results.inference));
  if (const auto reasons = results.verdict.reasons(); !reasons.empty()) say(doubts_in_words(reasons));
  say(next_step(results));
  return fmt::format("{}", fmt::join(sentences, " "));
}

}  // namespace kalfem
