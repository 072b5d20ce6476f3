// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/released_elements.hpp"

#include <algorithm>

#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {
namespace {

using Kind = LumpedParameter::Kind;
using Eigen::Index;

const std::string inertial_substructure = "inertial";

std::string inertial_point(StructureParts& parts) {
  if (std::ranges::find(parts.substructures, inertial_substructure, &LumpedSubstructure::name) ==
      parts.substructures.end()) {
    LumpedSubstructure frame;
    frame.name = inertial_substructure;
    frame.grounds = {"frame"};
    parts.substructures.push_back(frame);
  }
  return inertial_substructure + ".frame";
}

/// The connector that carries departures of the element at `place`. Stiffness and damping of a spring share one.
ConnectorDescription& connector_at(StructureParts& parts, const std::string& place, const std::string& from,
                                   const std::string& to) {
  for (auto& connector : parts.connectors)
    if (connector.name == place) return connector;
  return parts.connectors.emplace_back(ConnectorDescription{place, from, to, nullptr, Eigen::VectorXd::Zero(3)});
}

const LumpedSubstructure& owner_of(const StructureParts& parts, const Parameter& parameter) {
  return *std::ranges::find(parts.substructures, parameter.owner, &LumpedSubstructure::name);
}

/// Whether the law's stiffness at rest, and with it the modes of the whole structure, changes with a parameter.
bool shapes_modes(const ConnectorDescription& connector, Index parameter) {
  Eigen::VectorXd moved = connector.parameters;
  moved[parameter] = moved[parameter] == 0.0 ? 1.0 : 1.1 * moved[parameter];
  return stiffness_at_rest(*connector.law, connector.parameters) != stiffness_at_rest(*connector.law, moved);
}

bool base_accelerates(const StructureParts& parts) {
  return std::ranges::any_of(parts.inputs,
                             [](const auto& input) { return input.kind == InputKind::base_acceleration; });
}

}  // namespace

bool can_be_released(const StructureParts& parts, const Parameter& parameter) {
  if (parameter.of_connector()) return true;
  const auto* element = std::get_if<LumpedParameter>(&parameter.where);
  if (!element) return false;
  if (element->kind == Kind::mass) return !base_accelerates(parts);
  return element->kind == Kind::stiffness || element->kind == Kind::damping;
}

bool linear_part_follows(const StructureParts& parts, const Parameter& parameter) {
  if (const auto* of_law = std::get_if<ConnectorParameter>(&parameter.where))
    return parts.damping &&
           shapes_modes(*std::ranges::find(parts.connectors, parameter.owner, &ConnectorDescription::name),
                        of_law->position);
  const auto kind = std::get<LumpedParameter>(parameter.where).kind;
  if (kind == Kind::damping) return false;
  const auto& part = owner_of(parts, parameter);
  const auto& [mass_factor, stiffness_factor] = part.rayleigh;
  if (parts.damping || !part.modal_damping.empty() || mass_factor > 0.0) return true;
  return kind == Kind::stiffness && stiffness_factor > 0.0;
}

bool is_positive_by_nature(const Parameter& parameter) {
  const auto* element = std::get_if<LumpedParameter>(&parameter.where);
  return element ? element->kind == Kind::stiffness || element->kind == Kind::mass : !parameter.of_connector();
}

// A released element keeps its nominal value in the linear part. A connector carries the departure from it, with the
// value from the filter's state, so the total force is that of the state. Stiffness and damping of one spring share a
// connector. A mass departs against an inertial frame, as its force does not depend on the motion of any ground.
ParameterTarget release(StructureParts& parts, const Parameter& parameter, double nominal) {
  if (const auto* of_law = std::get_if<ConnectorParameter>(&parameter.where)) {
    const auto connector = std::ranges::find(parts.connectors, parameter.owner, &ConnectorDescription::name);
    connector->parameters[of_law->position] = nominal;
    return {connector - parts.connectors.begin(), of_law->position};
  }
  const auto& [kind, element] = std::get<LumpedParameter>(parameter.where);
  const LumpedSubstructure& part = owner_of(parts, parameter);
  std::string from, to, place;
  Index departure = 0;  // of the law: stiffness, damping, inertance
  if (kind == Kind::mass) {
    departure = 2;
    to = part.name + "." + part.masses[element].dof;
    place = to + ".mass";
    from = inertial_point(parts);
  } else {
    const auto& spring = part.springs[element];
    departure = kind == Kind::stiffness ? 0 : 1;
    place = part.name + "." + spring.name;
    from = part.name + "." + spring.from;
    to = part.name + "." + spring.to;
  }
  set_parameter(parts, parameter, nominal);
  auto& connector = connector_at(parts, place, from, to);
  connector.parameters[departure] = nominal;
  connector.law = linear_change_law({connector.parameters[0], connector.parameters[1], connector.parameters[2]});
  return {&connector - parts.connectors.data(), departure};
}

}  // namespace kalfem
