#include "kalfem/study/parameter_lookup.hpp"

#include <algorithm>

#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {
namespace {

using Kind = ParameterReference::Kind;

const std::string inertial_substructure = "inertial";

/// Visits (name, reference) of every parameter until the visitor returns true.
template <class Visitor>
void visit_parameters(const StructureParts& parts, const Visitor& visit) {
  for (std::size_t j = 0; j < parts.connectors.size(); ++j) {
    const auto& connector = parts.connectors[j];
    const auto& quantities = connector.law->parameters();
    for (std::size_t p = 0; p < quantities.size(); ++p)
      if (visit(connector.name + "." + quantities[p].name,
                {Kind::connector, j, p, quantities[p].unit, connector.parameters[static_cast<Eigen::Index>(p)]}))
        return;
  }
  for (std::size_t s = 0; s < parts.substructures.size(); ++s) {
    const auto& part = parts.substructures[s];
    for (std::size_t e = 0; e < part.springs.size(); ++e) {
      const std::string prefix = part.name + "." + part.springs[e].name;
      if (visit(prefix + ".stiffness", {Kind::spring_stiffness, s, e, "N/m", part.springs[e].stiffness})) return;
      if (visit(prefix + ".damping", {Kind::spring_damping, s, e, "N s/m", part.springs[e].damping})) return;
    }
    for (std::size_t e = 0; e < part.masses.size(); ++e)
      if (visit(part.name + "." + part.masses[e].dof + ".mass", {Kind::mass, s, e, "kg", part.masses[e].mass})) return;
  }
}

std::string inertial_point(StructureParts& parts) {
  const auto exists =
      std::ranges::any_of(parts.substructures, [](const auto& p) { return p.name == inertial_substructure; });
  if (!exists) {
    LumpedSubstructure frame;
    frame.name = inertial_substructure;
    frame.grounds = {"frame"};
    parts.substructures.push_back(frame);
  }
  return inertial_substructure + ".frame";
}

/// The connector that carries departures of the element at `place`; stiffness and damping of a spring share one.
ConnectorDescription& connector_at(StructureParts& parts, const std::string& place, const std::string& from,
                                   const std::string& to) {
  for (auto& connector : parts.connectors)
    if (connector.name == place) return connector;
  return parts.connectors.emplace_back(ConnectorDescription{place, from, to, nullptr, Eigen::VectorXd::Zero(3)});
}

/// Whether the law's stiffness at rest, and with it the modes of the whole structure, changes with a parameter.
bool shapes_modes(const ConnectorDescription& connector, std::size_t parameter) {
  const auto at = static_cast<Eigen::Index>(parameter);
  Eigen::VectorXd moved = connector.parameters;
  moved[at] = moved[at] == 0.0 ? 1.0 : 1.1 * moved[at];
  return stiffness_at_rest(*connector.law, connector.parameters) != stiffness_at_rest(*connector.law, moved);
}

bool base_accelerates(const StructureParts& parts) {
  return std::ranges::any_of(parts.inputs,
                             [](const auto& input) { return input.kind == InputKind::base_acceleration; });
}

}  // namespace

bool can_be_released(const StructureParts& parts, const ParameterReference& element) {
  return element.kind != Kind::mass || !base_accelerates(parts);
}

bool linear_part_follows(const StructureParts& parts, const ParameterReference& element) {
  if (element.kind == Kind::spring_damping) return false;
  if (element.kind == Kind::connector)
    return parts.damping && shapes_modes(parts.connectors[element.part], element.element);
  const auto& part = parts.substructures[element.part];
  const auto& [mass_factor, stiffness_factor] = part.rayleigh;
  if (parts.damping || !part.modal_damping.empty() || mass_factor > 0.0) return true;
  return element.kind == Kind::spring_stiffness && stiffness_factor > 0.0;
}

void set_parameter(StructureParts& parts, const ParameterReference& element, double value) {
  switch (element.kind) {
    case Kind::connector:
      parts.connectors[element.part].parameters[static_cast<Eigen::Index>(element.element)] = value;
      break;
    case Kind::spring_stiffness:
      parts.substructures[element.part].springs[element.element].stiffness = value;
      break;
    case Kind::spring_damping:
      parts.substructures[element.part].springs[element.element].damping = value;
      break;
    case Kind::mass:
      parts.substructures[element.part].masses[element.element].mass = value;
      break;
  }
}

std::optional<ParameterReference> find_parameter(const StructureParts& parts, const std::string& name) {
  std::optional<ParameterReference> found;
  visit_parameters(parts, [&](const std::string& candidate, const ParameterReference& reference) {
    if (candidate == name) found = reference;
    return found.has_value();
  });
  return found;
}

std::vector<std::string> parameter_names(const StructureParts& parts) {
  std::vector<std::string> names;
  visit_parameters(parts, [&](const std::string& name, const ParameterReference&) {
    names.push_back(name);
    return false;
  });
  return names;
}

ParameterReference release_linear_element(StructureParts& parts, const ParameterReference& element, double nominal) {
  if (element.kind == Kind::connector) return element;
  const auto& part = parts.substructures[element.part];
  std::string from, to, place;
  std::size_t parameter = 0;  // of linear_change: stiffness, damping, inertance
  if (element.kind == Kind::mass) {
    const auto& mass = part.masses[element.element];
    parameter = 2;
    place = to = part.name + "." + mass.dof;
    place += ".mass";
    from = inertial_point(parts);
  } else {
    const auto& spring = part.springs[element.element];
    const bool stiffness = element.kind == Kind::spring_stiffness;
    parameter = stiffness ? 0 : 1;
    place = part.name + "." + spring.name;
    from = part.name + "." + spring.from;
    to = part.name + "." + spring.to;
  }
  set_parameter(parts, element, nominal);
  auto& connector = connector_at(parts, place, from, to);
  connector.parameters[static_cast<Eigen::Index>(parameter)] = nominal;
  connector.law = linear_change_law({connector.parameters[0], connector.parameters[1], connector.parameters[2]});
  const auto index = static_cast<std::size_t>(&connector - parts.connectors.data());
  return {Kind::connector, index, parameter, element.unit, nominal};
}

}  // namespace kalfem
