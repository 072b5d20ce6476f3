// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fixed_numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"

namespace kalfem {

namespace {

constexpr std::array<std::pair<FixedNumberKind, const char*>, 9> groups{{{FixedNumberKind::mass, "masses"},
                                                                         {FixedNumberKind::stiffness, "stiffnesses"},
                                                                         {FixedNumberKind::damping, "damping"},
                                                                         {FixedNumberKind::position, "positions"},
                                                                         {FixedNumberKind::law, "laws"},
                                                                         {FixedNumberKind::gain, "gains"},
                                                                         {FixedNumberKind::excitation, "excitations"},
                                                                         {FixedNumberKind::delay, "delays"},
                                                                         {FixedNumberKind::drift, "drifts"}}};

/// The value of a parameter in the parts of this run, which an updating may have changed.
double present_value(const StructureParts& parts, const Parameter& parameter) {
  if (const auto* of_law = std::get_if<ConnectorParameter>(&parameter.where)) {
    const auto found = std::ranges::find(parts.connectors, parameter.owner, &ConnectorDescription::name);
    return found == parts.connectors.end() ? parameter.value : found->parameters[of_law->position];
  }
  const auto* lumped = std::get_if<LumpedParameter>(&parameter.where);
  const auto found = std::ranges::find(parts.substructures, parameter.owner, &LumpedSubstructure::name);
  return lumped && found != parts.substructures.end() ? value_of(*found, *lumped) : parameter.value;
}

/// By name and unit: a connector's k [N/m] is a stiffness as a spring's is.
FixedNumberKind kind_of(const Parameter& parameter) {
  const std::string& unit = parameter.unit;
  if (parameter.name.find(".damping") != std::string::npos || unit.starts_with("N s")) return FixedNumberKind::damping;
  if (unit.starts_with("kg")) return FixedNumberKind::mass;
  if (parameter.name.find(".offset_") != std::string::npos) return FixedNumberKind::position;
  if (unit.starts_with("N/m") || unit.starts_with("N m/rad") || !parameter.of_connector())
    return FixedNumberKind::stiffness;
  return FixedNumberKind::law;
}

FixedNumber number_of(const Parameter& parameter) {
  return {.name = parameter.name,
          .unit = parameter.unit,
          .value = parameter.value,
          .scale = std::abs(parameter.value),
          .kind = kind_of(parameter),
          .parameter = parameter};
}

/// All ratios as one are their single ones again.
bool repeats_others(const Parameter& parameter) { return parameter.name.ends_with(".damping.modal"); }

std::string name_of(const std::string& source) { return source.starts_with('@') ? source.substr(1) : source; }

bool is_found_by_likelihood(const EstimationSettings& settings, LikelihoodUnknownKind kind, const std::string& sensor) {
  return std::ranges::any_of(settings.likelihood_unknowns,
                             [&](const auto& each) { return each.kind == kind && each.is_of(sensor); });
}

bool is_unknown_input(const EstimationSettings& settings, const std::string& name) {
  return std::ranges::find(settings.unknown_inputs, name, &UnknownInput::name) != settings.unknown_inputs.end();
}

bool is_group(const std::string& name) {
  return std::ranges::any_of(groups, [&](const auto& group) { return name == group.second; });
}

/// What is stated of a number: by the longest name, a group last; null where nothing is.
const KnownTo* stated_of(const std::vector<KnownTo>& all, const FixedNumber& number) {
  const KnownTo* best = nullptr;
  const auto rank = [](const KnownTo& each) { return is_group(each.name) ? std::size_t{0} : each.name.size(); };
  for (const auto& each : all)
    if (is_named(number, each.name) && (!best || rank(each) > rank(*best))) best = &each;
  return best;
}

void take_stated(const std::vector<KnownTo>& stated, FixedNumber& number) {
  const KnownTo* known = stated_of(stated, number);
  if (!known || (known->relative && (number.is_of_clock() || number.value == 0.0))) return;
  if (number.scale == 0.0) number.scale = known->deviation;
  number.deviation = known->relative ? known->deviation : known->deviation / number.scale;
}

void check_size(const KnownTo& stated, const std::string& path, IssueList& issues) {
  if (!(stated.deviation > 0.0) || !std::isfinite(stated.deviation))
    issues.add(stated.location, path + ": it is " + shortest(stated.deviation),
               "a number that is known exactly needs no entry", "give a standard deviation above 0, or remove it");
  else if (stated.relative && stated.deviation > 1.0)
    issues.add(stated.location, path + ": it is " + shortest(100.0 * stated.deviation) + " %",
               "a number that is known that badly is an unknown", "estimate it: add it to the unknowns");
}

}  // namespace

std::string group_of(FixedNumberKind kind) {
  return std::ranges::find(groups, kind, &std::pair<FixedNumberKind, const char*>::first)->second;
}

bool is_named(const FixedNumber& number, const std::string& name) {
  return name == number.name || number.name.starts_with(name + ".") || name == group_of(number.kind);
}

std::set<std::string> estimated_parameters(const EstimationSettings& settings,
                                           const std::vector<std::string>& updated) {
  std::set<std::string> estimated(updated.begin(), updated.end());
  for (const auto& unknown : settings.unknowns)
    for (const auto& target : unknown.targets) estimated.insert(target.name);
  return estimated;
}

std::vector<Parameter> fixed_parameters(const StructureModel& structure, const StructureParts& parts,
                                        const std::set<std::string>& estimated) {
  const ParameterSet all(structure);
  std::vector<Parameter> fixed;
  for (const auto& name : all.names())
    if (auto parameter = all.find(name); parameter && !estimated.contains(name)) {
      parameter->value = present_value(parts, *parameter);
      if (std::isfinite(parameter->value)) fixed.push_back(*parameter);
    }
  return fixed;
}

std::vector<FixedNumber> held_numbers(const EstimationProblem& problem, const StructureParts& parts,
                                      const AugmentedModelSetup& setup, const std::vector<std::string>& updated) {
  const auto& settings = problem.settings;
  std::vector<FixedNumber> all;
  for (const auto& parameter : fixed_parameters(*problem.structure, parts, estimated_parameters(settings, updated)))
    if (!repeats_others(parameter)) all.push_back(number_of(parameter));
  const auto add = [&](const std::string& of, FixedNumberKind gain, bool gain_is_fixed, bool delay_is_fixed) {
    FixedNumber number{.scale = 1.0, .of_sensor = gain == FixedNumberKind::gain};
    number.name = of + ".gain", number.unit = "-", number.value = 1.0, number.kind = gain;
    if (gain_is_fixed) all.push_back(number);
    number.name = of + ".delay", number.unit = "s", number.value = 0.0, number.kind = FixedNumberKind::delay;
    if (delay_is_fixed) all.push_back(number);
  };
  for (const auto& sensor : setup.sensors) {
    add(sensor.name, FixedNumberKind::gain,
        !is_found_by_likelihood(settings, LikelihoodUnknownKind::sensor_gain, sensor.name),
        !is_found_by_likelihood(settings, LikelihoodUnknownKind::sensor_delay, sensor.name));
    if (!is_found_by_likelihood(settings, LikelihoodUnknownKind::sensor_drift, sensor.name))
      all.push_back({.name = sensor.name + ".drift",
                     .unit = "-",
                     .scale = 1.0,
                     .kind = FixedNumberKind::drift,
                     .of_sensor = true});
  }
  for (const auto& source : setup.input_sources)
    if (!source.empty() && !is_unknown_input(settings, source))
      add(name_of(source), FixedNumberKind::excitation, true, true);
  return all;
}

std::vector<FixedNumber> fixed_numbers(const EstimationProblem& problem, const StructureParts& parts,
                                       const AugmentedModelSetup& setup, const std::vector<std::string>& updated) {
  std::vector<FixedNumber> all = held_numbers(problem, parts, setup, updated);
  for (auto& number : all) take_stated(problem.settings.known_to, number);
  std::erase_if(all, [](const FixedNumber& number) { return number.scale == 0.0; });
  return all;
}

std::vector<FixedNumber> stated_numbers(std::vector<FixedNumber> all, const std::vector<KnownTo>& known_to) {
  for (auto& number : all) take_stated(known_to, number);
  std::erase_if(all, [](const FixedNumber& number) { return number.deviation == 0.0; });
  return all;
}

std::vector<FixedNumber> held_in_updating(const StructureModel& structure, const std::set<std::string>& refined,
                                          const std::vector<ComparedGain>& gains, bool with_connectors) {
  std::vector<FixedNumber> all;
  for (const auto& parameter : fixed_parameters(structure, structure.parts, refined))
    if (!repeats_others(parameter) && (with_connectors || !parameter.of_connector()))
      all.push_back(number_of(parameter));
  for (const auto& [name, of_input] : gains)
    all.push_back({.name = name,
                   .unit = "-",
                   .value = 1.0,
                   .scale = 1.0,
                   .kind = of_input ? FixedNumberKind::excitation : FixedNumberKind::gain,
                   .of_sensor = !of_input});
  return all;
}

void check_known_to(const EstimationProblem& problem, const StructureParts& parts, const AugmentedModelSetup& setup,
                    IssueList& issues) {
  auto estimated = estimated_parameters(problem.settings, {});
  for (const auto& unknown : problem.settings.likelihood_unknowns)
    for (const auto& sensor : unknown.sensors) estimated.insert(sensor + "." + quantity_of(unknown.name));
  check_known_to(problem.settings.known_to, held_numbers(problem, parts, setup, {}), estimated, issues);
}

void check_known_to(const std::vector<KnownTo>& known_to, const std::vector<FixedNumber>& all,
                    const std::set<std::string>& estimated, IssueList& issues) {
  std::vector<std::string> known;
  for (const auto& group : groups) known.emplace_back(group.second);
  for (const auto& number : all) known.push_back(number.name);
  for (const auto& stated : known_to) {
    const std::string path = "known_to." + stated.name;
    check_size(stated, path, issues);
    const auto is_named = [&](const FixedNumber& number) { return kalfem::is_named(number, stated.name); };
    if (estimated.contains(stated.name))
      issues.add(stated.location, path + ": it is estimated", "its prior says how well it is known",
                 "state `std` of this unknown, and remove it here");
    else if (std::ranges::none_of(all, is_named) && !is_group(stated.name))
      issues.add(stated.location, path + ": no fixed number has this name" + did_you_mean(stated.name, known), "",
                 "name a number as `sensitivity` of summary.json lists it, or one of masses, stiffnesses, damping, "
                 "positions, laws, gains, excitations, delays, drifts");
    const auto has_no_size = [&](const FixedNumber& number) {
      return is_named(number) && (number.is_of_clock() ? stated.name != number.name.substr(0, number.name.rfind('.'))
                                                       : number.scale == 0.0 && stated.name == number.name);
    };
    std::set<std::string> units;
    for (const auto& number : all)
      if (is_named(number)) units.insert(number.unit);
    if (!stated.relative && units.size() > 1)
      issues.add(stated.location, path + ": one deviation for numbers of several units", "it would fit none of them",
                 "give a percentage, or name single numbers");
    if (stated.relative && std::ranges::any_of(all, has_no_size))
      issues.add(stated.location, path + ": a percentage of a number that is 0", "it has no size to take a part of",
                 "give the standard deviation in its unit");
  }
}

}  // namespace kalfem
