#include "kalfem/casefile/unknown_targets.hpp"

#include <algorithm>

#include "kalfem/system/law_library.hpp"

namespace kalfem {
namespace {

using Kind = ParameterReference::Kind;

const std::string inertial_substructure = "inertial";

/// Visits (name, reference) of every parameter until the visitor returns true.
template <class Visitor>
void visit_parameters(const Parts& parts, const Visitor& visit) {
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

std::string inertial_point(Parts& parts) {
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

}  // namespace

std::optional<ParameterReference> find_parameter(const Parts& parts, const std::string& name) {
  std::optional<ParameterReference> found;
  visit_parameters(parts, [&](const std::string& candidate, const ParameterReference& reference) {
    if (candidate == name) found = reference;
    return found.has_value();
  });
  return found;
}

std::vector<std::string> parameter_names(const Parts& parts) {
  std::vector<std::string> names;
  visit_parameters(parts, [&](const std::string& name, const ParameterReference&) {
    names.push_back(name);
    return false;
  });
  return names;
}

ParameterReference release_linear_element(Parts& parts, const ParameterReference& element, double nominal) {
  if (element.kind == Kind::connector) return element;
  auto& part = parts.substructures[element.part];
  ConnectorDescription connector;
  LinearNominal values;
  std::size_t parameter = 0;
  if (element.kind == Kind::mass) {
    auto& mass = part.masses[element.element];
    mass.mass = values.inertance = nominal;
    parameter = 2;
    connector = {part.name + "." + mass.dof + ".mass", "", part.name + "." + mass.dof, nullptr, {}};
    connector.from = inertial_point(parts);
  } else {
    auto& spring = part.springs[element.element];
    const bool stiffness = element.kind == Kind::spring_stiffness;
    (stiffness ? spring.stiffness : spring.damping) = nominal;
    (stiffness ? values.stiffness : values.damping) = nominal;
    parameter = stiffness ? 0 : 1;
    connector = {part.name + "." + spring.name + (stiffness ? ".stiffness" : ".damping"),
                 part.name + "." + spring.from,
                 part.name + "." + spring.to,
                 nullptr,
                 {}};
  }
  connector.law = linear_change_law(values);
  connector.parameters = Eigen::Vector3d(values.stiffness, values.damping, values.inertance);
  parts.connectors.push_back(connector);
  return {Kind::connector, parts.connectors.size() - 1, parameter, element.unit, nominal};
}

}  // namespace kalfem
