// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kalfem/page/words.hpp"
#include "kalfem/report/finished/sweep_report.hpp"
#include "kalfem/steps/estimation/report.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The runs of one combination.
using Group = std::vector<const FinishedSweepRun*>;

std::vector<Group> groups_of(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs) {
  std::vector<Group> groups(plan.combinations());
  for (const auto& run : runs) groups[run.run.number * groups.size() / plan.size()].push_back(&run);
  return groups;
}

/// Names with their units in the order in which the runs name them.
std::vector<FoundParameter> parameters_of(const std::vector<FinishedSweepRun>& runs) {
  std::vector<FoundParameter> all;
  for (const auto& run : runs) {
    if (!run.found) continue;
    for (const auto& parameter : run.found->parameters())
      if (std::ranges::find(all, parameter.name, &FoundParameter::name) == all.end()) all.push_back(parameter);
  }
  return all;
}

/// What the usable runs of a combination found of one parameter.
std::vector<FoundParameter> found_in(const Group& group, const std::string& name) {
  std::vector<FoundParameter> found;
  for (const auto* run : group) {
    if (!run->found || !run->found->usable) continue;
    const auto parameters = run->found->parameters();
    const auto place = std::ranges::find(parameters, name, &FoundParameter::name);
    if (place != parameters.end() && place->estimate) found.push_back(*place);
  }
  return found;
}

std::string text(const std::optional<double>& value) { return value ? four_digits(*value) : "-"; }

std::optional<double> mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size())).mean();
}

std::optional<double> spread(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  const Eigen::Map<const VectorXd> all(values.data(), static_cast<Index>(values.size()));
  return std::sqrt((all.array() - all.mean()).square().sum() / static_cast<double>(all.size() - 1));
}

/// The known values of some number.
template <class Read>
std::vector<double> known(const std::vector<FoundParameter>& parameters, const Read& read) {
  std::vector<double> values;
  for (const auto& parameter : parameters)
    if (const std::optional<double> value = read(parameter)) values.push_back(*value);
  return values;
}

/// 1 where the 95 % interval holds the truth.
std::optional<double> covers(const FoundParameter& parameter) {
  if (!parameter.truth || !parameter.interval) return std::nullopt;
  const auto& [lower, upper] = *parameter.interval;
  return lower <= *parameter.truth && *parameter.truth <= upper ? 1.0 : 0.0;
}

std::vector<std::string> keys_of(const SweepPlan& plan) {
  std::vector<std::string> keys;
  for (const auto& axis : plan.axes) keys.push_back(axis.key);
  return keys;
}

void append(std::vector<std::string>& row, std::vector<std::string> cells) {
  row.insert(row.end(), std::make_move_iterator(cells.begin()), std::make_move_iterator(cells.end()));
}

Table run_table(const SweepPlan& plan, const std::vector<Group>& groups) {
  Table table{"Runs", keys_of(plan)};
  append(table.columns, {"runs", "consistent", "suspicious", "unusable", "refused", "mean NIS"});
  for (std::size_t g = 0; g < groups.size(); ++g) {
    std::array<int, 3> states{};
    int refused = 0;
    std::vector<double> nis;
    for (const auto* run : groups[g]) {
      if (!run->found) {
        ++refused;
        continue;
      }
      const auto state = run->found->usable ? run->found->verdict : VerdictState::unusable;
      ++states[static_cast<std::size_t>(state)];
      if (const auto& filter = run->found->filter; filter && filter->consistency.mean_nis)
        nis.push_back(*filter->consistency.mean_nis);
    }
    auto& row = table.rows.emplace_back(plan.values(g));
    append(row, {std::to_string(groups[g].size()), std::to_string(states[0]), std::to_string(states[1]),
                 std::to_string(states[2]), std::to_string(refused), text(mean(nis))});
  }
  return table;
}

Table parameter_table(const SweepPlan& plan, const std::vector<Group>& groups, const FoundParameter& parameter) {
  const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
  Table table{parameter.name + unit, keys_of(plan)};
  append(table.columns, {"runs", "mean estimate", "spread of estimates", "mean std", "true", "truth in 95 % [%]"});
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto found = found_in(groups[g], parameter.name);
    const auto estimates = known(found, [](const auto& one) { return one.estimate; });
    const auto deviations = known(found, [](const auto& one) { return one.deviation(); });
    const auto covered = mean(known(found, covers));
    auto& row = table.rows.emplace_back(plan.values(g));
    append(row, {std::to_string(found.size()), text(mean(estimates)), text(spread(estimates)), text(mean(deviations)),
                 text(mean(known(found, [](const auto& one) { return one.truth; }))),
                 covered ? four_digits(100.0 * *covered) : "-"});
  }
  return without_empty_columns(table);
}

}  // namespace

std::vector<Table> sweep_tables(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs) {
  const auto groups = groups_of(plan, runs);
  std::vector<Table> tables{run_table(plan, groups)};
  for (const auto& parameter : parameters_of(runs)) tables.push_back(parameter_table(plan, groups, parameter));
  return tables;
}

}  // namespace kalfem
