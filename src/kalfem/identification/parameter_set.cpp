// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameter_set.hpp"

#include <algorithm>

namespace kalfem {
namespace {

/// A spring's stiffness is along a displacement or about an axis.
std::string unit_of(const FiniteElementModel& model, const FiniteElementParameter& parameter) {
  const std::string unit = kalfem::unit_of(parameter);
  if (!unit.empty()) return unit;
  for (const auto& spring : model.springs)
    if (parameter.name == spring.name + ".stiffness" && spring.from.direction >= 3) return "N m/rad";
  return "N/m";
}

void add_connectors(const StructureModel& structure, std::vector<Parameter>& all) {
  for (const auto& connector : structure.parts.connectors) {
    const auto& quantities = connector.law->parameters();
    for (std::size_t p = 0; p < quantities.size(); ++p) {
      const auto position = static_cast<Eigen::Index>(p);
      all.push_back({connector.name + "." + quantities[p].name, connector.name, quantities[p].unit,
                     connector.parameters[position], ConnectorParameter{position}});
    }
  }
}

void add_lumped(const StructureModel& structure, std::vector<Parameter>& all) {
  for (const auto& part : structure.parts.substructures)
    for (const auto& [name, target] : parameters_of(part))
      all.push_back({part.name + "." + name, part.name, kalfem::unit_of(target.kind), value_of(part, target), target});
}

void add_finite_elements(const StructureModel& structure, std::vector<Parameter>& all) {
  for (const auto& each : structure.finite_elements) {
    const FiniteElementPart& part = *each.part;
    for (const auto& [name, target] : parameters_of(part.assembled, part.damping))
      all.push_back({part.name + "." + name, part.name, unit_of(part.elements, target),
                     value_of(part.assembled, part.damping, target), target});
  }
}

}  // namespace

ParameterSet::ParameterSet(const StructureModel& structure) {
  add_connectors(structure, parameters_);
  add_lumped(structure, parameters_);
  add_finite_elements(structure, parameters_);
  for (const auto& parameter : parameters_) names_.push_back(parameter.name);
  for (const auto& each : structure.finite_elements)
    for (const auto& asked :
         {beam_factors(each.part->elements), mass_offsets(each.part->elements), part_factors(each.part->elements)})
      for (const auto& [factor, value] : asked)
        if (const std::string name = each.part->name + "." + factor; !find(name)) names_.push_back(name);
}

std::optional<Parameter> ParameterSet::find(const std::string& name) const {
  const auto found = std::ranges::find(parameters_, name, &Parameter::name);
  return found == parameters_.end() ? std::nullopt : std::optional(*found);
}

bool set_parameter(StructureParts& parts, const Parameter& parameter, double value) {
  if (const auto* of_law = std::get_if<ConnectorParameter>(&parameter.where)) {
    const auto found = std::ranges::find(parts.connectors, parameter.owner, &ConnectorDescription::name);
    if (found == parts.connectors.end()) return false;
    found->parameters[of_law->position] = value;
    return true;
  }
  const auto* lumped = std::get_if<LumpedParameter>(&parameter.where);
  const auto found = std::ranges::find(parts.substructures, parameter.owner, &LumpedSubstructure::name);
  if (!lumped || found == parts.substructures.end()) return false;
  set_value(*found, *lumped, value);
  return true;
}

}  // namespace kalfem
