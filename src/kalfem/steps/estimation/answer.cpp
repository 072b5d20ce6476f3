// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/identified_parameters.hpp"

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

}  // namespace

std::string estimation_answer(const Study& study, const EstimationOutcome& outcome) {
  const auto parameters = identified_unknowns(study, outcome);
  const auto& record = outcome.measurements;
  const std::string from =
      fmt::format("from {} over {} s", sensors_in_words(study, record), four_digits(record.end() - record.start));
  if (parameters.empty()) return "The motion of the whole structure was estimated " + from + ".";
  const std::string sure = precision_in_words(parameters);
  return fmt::format("Identified {}: {}{}.", from, found_in_words(parameters), sure.empty() ? "" : "; " + sure);
}

}  // namespace kalfem
