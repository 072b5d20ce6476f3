// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/run_population.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers are written with the two digits of half their interval's half.
double scale_of(const PopulationEstimate& told) { return 0.25 * (told.interval[1] - told.interval[0]); }

std::string interval_text(const DisplayUnit& shown, const PopulationEstimate& told) {
  return shown.value(told.interval[0], scale_of(told)) + " to " + shown.value(told.interval[1], scale_of(told));
}

std::string with_interval(const DisplayUnit& shown, const PopulationEstimate& told) {
  return shown.value(told.median, scale_of(told)) + " (" + interval_text(shown, told) + ")";
}

Json told_json(const PopulationEstimate& told) { return {{"median", told.median}, {"interval", told.interval}}; }

DisplayUnit shown_in(const ParameterPopulation& parameter) { return {parameter.unit, {parameter.of.mean.median}}; }

}  // namespace

std::vector<ParameterPopulation> parameter_populations(const RunComparison& comparison) {
  std::vector<ParameterPopulation> all;
  for (const auto& parameter : compared_parameters(comparison)) {
    ParameterPopulation population{parameter.name, parameter.unit, {}, {}};
    std::vector<PopulationMember> members;
    for (std::size_t i = 0; i < parameter.runs.size(); ++i)
      if (const auto& run = parameter.runs[i]; run && run->estimate && run->deviation().value_or(0.0) > 0.0) {
        population.runs.push_back(i);
        members.push_back({*run->estimate, *run->deviation()});
      }
    if (members.size() < 2) continue;
    population.of = population_of(members);
    all.push_back(std::move(population));
  }
  if (all.empty())
    throw InvalidInput("compare: no parameter was found with a standard deviation by two runs or more",
                       "the spread of a population is told from the parameters of its members",
                       "give runs that identify the same parameters, or leave --population out");
  return all;
}

std::vector<Table> population_tables(const RunComparison& comparison) {
  Table population{"Population: the runs as members of one, medians and 95 % intervals",
                   {"parameter", "unit", "mean", "standard deviation of the members", "of the mean", "the next member"},
                   {},
                   {}};
  Table members{"Members: each with what the others tell of it, 95 % intervals", {"parameter", "unit"}, {}, {}};
  members.columns.insert(members.columns.end(), comparison.labels.begin(), comparison.labels.end());
  for (const auto& parameter : parameter_populations(comparison)) {
    const auto& [mean, spread, next, each] = parameter.of;
    const DisplayUnit shown = shown_in(parameter);
    population.rows.push_back({parameter.name, shown.unit(), with_interval(shown, mean), with_interval(shown, spread),
                               per_cent(spread.median / std::abs(mean.median)), interval_text(shown, next)});
    std::vector<std::string> row(comparison.runs.size() + 2, "-");
    row[0] = parameter.name;
    row[1] = shown.unit();
    for (std::size_t k = 0; k < each.size(); ++k) row[parameter.runs[k] + 2] = interval_text(shown, each[k]);
    members.rows.push_back(std::move(row));
  }
  return {std::move(population), std::move(members)};
}

Json population_json(const RunComparison& comparison) {
  Json json = Json::object();
  for (const auto& parameter : parameter_populations(comparison)) {
    Json runs(std::vector<Json>(comparison.runs.size()));
    for (std::size_t k = 0; k < parameter.runs.size(); ++k)
      runs[parameter.runs[k]] = told_json(parameter.of.members[k]);
    json[parameter.name] = {{"unit", parameter.unit},
                            {"mean", told_json(parameter.of.mean)},
                            {"spread", told_json(parameter.of.spread)},
                            {"next", told_json(parameter.of.next)},
                            {"runs", runs}};
  }
  return json;
}

}  // namespace kalfem
