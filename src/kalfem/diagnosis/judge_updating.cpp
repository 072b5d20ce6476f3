// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/judge_updating.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/identification/record_residual.hpp"
#include "kalfem/updating/frf_record_residual.hpp"
#include "kalfem/verdict/updating_checks.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Values less the parameters' share of them, which is taken as the same for every comparison.
double degrees_of_freedom(const EndOfComparison& comparison, const EndOfUpdating& updating) {
  double values = 0.0;
  for (const auto& each : updating.comparisons) values += static_cast<double>(each.size);
  return static_cast<double>(comparison.size) * updating.statistics.degrees_of_freedom / std::max(1.0, values);
}

ComparedMeasurement compared_measurement(const EndOfComparison& comparison, const EndOfUpdating& updating) {
  constexpr double least_mac = 0.5;
  ComparedMeasurement compared{.name = comparison.name,
                               .rms = comparison.rms,
                               .degrees_of_freedom = degrees_of_freedom(comparison, updating),
                               .has_bounds = comparison.has_bounds};
  for (const auto& mode : comparison.modes)
    if (!mode.model_mode || mode.mac < least_mac)
      compared.poor_pairs.push_back(fmt::format("{:.4g} Hz (MAC {:.2f})", mode.measured_frequency, mode.mac));
  return compared;
}

bool is_positive_by_nature(const std::string& name) {
  constexpr std::array endings = {".stiffness", ".mass", ".thickness", ".youngs_modulus", ".density"};
  return std::ranges::any_of(endings, [&](const char* ending) { return name.ends_with(ending); });
}

UpdatedValue updated_value(Index i, const EndOfUpdating& updating) {
  const auto& parameter = updating.parameters[static_cast<std::size_t>(i)];
  const double stated = updating.statistics.deviations[i], robust = updating.robust.deviations[i];
  UpdatedValue value{.name = parameter.name,
                     .unit = parameter.unit,
                     .initial = parameter.initial,
                     .value = updating.values[i],
                     .at_bound = updating.statistics.at_bound[static_cast<std::size_t>(i)],
                     .positive_by_nature = is_positive_by_nature(parameter.name)};
  if (std::isfinite(parameter.deviation)) value.prior_deviation = parameter.deviation;
  if (std::isfinite(robust) && stated > 0.0 && std::isfinite(stated)) value.widening = robust / stated;
  value.widening_freedom = updating.robust.degrees_of_freedom;
  return value;
}

/// Names of what the data do not determine: combinations and pairs, and single parameters that are in none of them.
void add_identifiability(const EndOfUpdating& updating, UpdatingRecord& record) {
  const auto& parameters = updating.parameters;
  const auto& statistics = updating.statistics;
  const auto name = [&](Index i) { return parameters[static_cast<std::size_t>(i)].name; };
  std::vector<bool> named(parameters.size(), false);
  for (const auto& combination : statistics.unidentifiable) {
    auto& names = record.not_told_apart.emplace_back();
    for (const Index i : combination.parameters) {
      names.push_back(name(i));
      named[static_cast<std::size_t>(i)] = true;
    }
  }
  for (const auto& pair : statistics.correlated) record.not_told_apart.push_back({name(pair.first), name(pair.second)});
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (!named[i] && (statistics.seen[i] == Seen::poorly || statistics.seen[i] == Seen::not_at_all))
      record.not_identified.push_back(parameters[i].name);
}

}  // namespace

bool has_bounds(const Residual& residual) {
  return dynamic_cast<const RecordResidual*>(&residual) || dynamic_cast<const FrfRecordResidual*>(&residual);
}

std::vector<Reason> updating_reasons(const EndOfUpdating& updating) {
  UpdatingRecord record{.converged = updating.converged, .termination = updating.termination};
  for (const auto& comparison : updating.comparisons)
    record.comparisons.push_back(compared_measurement(comparison, updating));
  for (Index i = 0; i < updating.values.size(); ++i) record.parameters.push_back(updated_value(i, updating));
  add_identifiability(updating, record);
  return updating_reasons(record);
}

}  // namespace kalfem
