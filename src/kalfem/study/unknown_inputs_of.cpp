// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/unknown_inputs_of.hpp"

#include <algorithm>
#include <limits>

#include "kalfem/study/spread.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Whether the excitation is the acceleration of named grounds, whose integral displaces them.
bool accelerates_grounds(const d::Excitation& given, const InputDescription& input) {
  return input.kind == InputKind::base_displacement && std::holds_alternative<d::BaseAcceleration>(given.target);
}

UnknownInput read(const d::Excitation& given, const InputDescription& input, double sample_rate) {
  const auto& [assumed, location, path] = *given.unknown;
  if (std::holds_alternative<d::BaseVelocity>(given.target))
    throw InvalidInput(Issue{location, path + " has no effect here",
                             "the motion of a ground is estimated as a displacement or as an acceleration",
                             "write base_displacement or base_acceleration in place of base_velocity"});
  UnknownInput unknown{.name = input.name, .acceleration = accelerates_grounds(given, input), .location = location};
  unknown.unit = unknown.acceleration ? "m/s^2" : unit_of(input.kind);
  unknown.has_truth = given.signal.has_value();
  if (assumed.std) unknown.deviation = checked_number(*assumed.std, unknown.unit, Bounds::nonnegative());
  if (assumed.random_walk) {
    unknown.process = {.order = 1, .correlation_time = std::numeric_limits<double>::infinity()};
    unknown.density = checked_number(walk_in(*assumed.random_walk, unknown.unit), unknown.unit, Bounds::positive());
    return unknown;
  }
  if (!(unknown.deviation > 0.0))
    throw InvalidInput(assumed.std->issue("its standard deviation is 0", "the filter would hold the excitation at 0",
                                          "give the size that the excitation may have"));
  const int smoothest = input.kind == InputKind::base_displacement && !unknown.acceleration ? 3 : 2;
  unknown.process = {.order = assumed.order.value_or(smoothest), .correlation_time = assumed.correlation_time};
  if (assumed.correlation_time * sample_rate < 1.0)
    throw InvalidInput(Issue{location,
                             path + ": its correlation time, " + shortest(assumed.correlation_time) +
                                 " s, is shorter than the sample interval, " + shortest(1.0 / sample_rate) + " s",
                             "the excitation would forget itself from one sample to the next",
                             "give a correlation time of a few samples or more"});
  unknown.density = unknown.process.density(unknown.deviation);
  return unknown;
}

/// Steps that simulate forward need every excitation.
void check_other_steps(const CaseStudy& study, const SourceLocation& place, const std::string& name,
                       IssueList& issues) {
  const auto refuse = [&](const std::string& key, const std::string& why) {
    issues.add(place, "excitation." + name + " is unknown, but the case has `" + key + "`", why,
               "remove `" + key + "`, or measure the excitation");
  };
  if (study.given.validate) refuse("validate", "a simulation of the held-back part needs every excitation");
  if (study.given.update) refuse("update", "its comparisons with records need every excitation");
}

}  // namespace

std::vector<UnknownInput> unknown_inputs_of(const CaseStudy& study, IssueList& issues) {
  std::vector<UnknownInput> unknown;
  for (const auto& input : study.structure->parts.inputs) {
    const auto found =
        std::ranges::find(study.given.excitation, input.name, &std::pair<std::string, d::Excitation>::first);
    if (found == study.given.excitation.end() || !found->second.unknown) continue;
    try {
      unknown.push_back(read(found->second, input, study.sample_rate()));
      check_other_steps(study, found->second.unknown->location, input.name, issues);
    } catch (const InvalidInput& error) {
      issues.add(error, found->second.unknown->location);
    }
  }
  return unknown;
}

void check_unknown_excitations(const d::Case& given, IssueList& issues) {
  for (const auto& [name, excitation] : given.excitation) {
    if (!excitation.unknown) continue;
    const auto& place = excitation.unknown->location;
    if (!given.estimate)
      issues.add(place, "excitation." + name + " is unknown, but the case has no `estimate`",
                 "nothing estimates the excitation", "add `estimate`, or remove `unknown`");
    if (given.simulate && !excitation.signal)
      issues.add(place, "excitation." + name + " has no signal, but the case has `simulate`",
                 "the simulation needs a signal that drives it; the filter does not see it",
                 "give a signal beside `unknown`, such as random");
  }
}

}  // namespace kalfem
