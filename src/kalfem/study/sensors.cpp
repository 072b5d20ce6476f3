// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/casefile/plausible.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Whether noise is a share of the channel's rms. Of a strain, which is a ratio itself, only a percentage is.
bool is_relative(const Quantity& noise, bool strain) {
  return strain ? noise.per_cent : !noise.bare && noise.dimension == Dimension{};
}

Sensor make_sensor(const std::string& name, const d::Sensor& given, const SourceLocation& location) {
  Sensor sensor;
  sensor.location = location;
  sensor.name = name;
  std::visit(
      [&](const auto& observed) {
        sensor.output = {
            name, observed.quantity, {observed.points.value.begin(), observed.points.value.end()}, given.relative};
      },
      given.observed);
  sensor.unit = unit_of(sensor.output.quantity);
  const bool strain = sensor.output.quantity == ObservedQuantity::strain;
  sensor.relative_noise = is_relative(given.noise.value, strain);
  sensor.noise = sensor.relative_noise
                     ? given.noise.value.value
                     : checked_number(given.noise, sensor.unit, strain ? plausible::strain() : Bounds::nonnegative());
  if (!(sensor.noise >= 0.0))
    throw InvalidInput(given.noise.issue("the noise is negative", "a standard deviation must not be negative"));
  sensor.chain = MeasurementChain({given.chain});
  return sensor;
}

/// The masses that a load cell carries beside its connectors: f + m a of the end `to`, f - m a of the end `from`.
DofCombination carried_masses(const CaseStudy& study, const d::Sensor& given, const OutputDescription& output) {
  if (!given.mass) return {};
  if (output.quantity != ObservedQuantity::connector_force)
    throw InvalidInput(given.mass->issue("a mass of " + shortest(given.mass->value) + " kg is given",
                                         "only a load cell measures the inertia of what it carries",
                                         "remove it, or write force: CONNECTOR"));
  DofCombination masses;
  const bool at_to = given.mass_at == d::ConnectorEnd::to;
  for (const auto& [name, weight] : output.points) {
    const auto& connectors = study.structure->parts.connectors;
    const auto connector = std::ranges::find(connectors, name, &ConnectorDescription::name);
    if (connector == connectors.end()) continue;  // make_outputs() says so
    masses[at_to ? connector->to : connector->from] += (at_to ? weight : -weight) * given.mass->value;
  }
  return masses;
}

/// A sensor relative to the base needs a base that moves as a whole.
void check_relative(const CaseStudy& study, const d::Sensor& given, const d::Points& points, IssueList& issues) {
  const bool uniform = std::ranges::any_of(
      study.structure->parts.inputs, [](const auto& input) { return input.kind == InputKind::base_acceleration; });
  const bool motion = std::visit([](const auto& observed) { return is_motion(observed.quantity); }, given.observed);
  if (given.relative && !uniform && motion)
    issues.add(points.location,
               points.path + " is relative to the accelerated base, but the case does not accelerate a whole base",
               "when single grounds move, displacements are absolute",
               "write {point: 1, ground: -1} for the motion relative to a ground");
}

}  // namespace

std::vector<Sensor> make_sensors(const CaseStudy& study, IssueList& issues) {
  std::vector<Sensor> sensors;
  for (const auto& [name, given] : study.given.sensors) {
    const auto location = std::visit([](const auto& observed) { return observed.points.location; }, given.observed);
    try {
      sensors.push_back(make_sensor(name, given, study.given.source.at({"sensors", name})));
      std::visit([&](const auto& observed) { check_relative(study, given, observed.points, issues); }, given.observed);
      sensors.back().output.carried_masses = carried_masses(study, given, sensors.back().output);
      make_outputs(*study.model, {sensors.back().output});
    } catch (const InvalidInput& error) {
      issues.add(error, location);
    }
  }
  return sensors;
}

}  // namespace kalfem
