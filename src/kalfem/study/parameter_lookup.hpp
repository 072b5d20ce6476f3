#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/assembly.hpp"

namespace kalfem {

/// A parameter of the case by its name.
struct ParameterReference {
  enum class Kind { connector, spring_stiffness, spring_damping, mass };
  Kind kind = Kind::connector;
  std::size_t part = 0;     ///< index of the connector, or of the substructure
  std::size_t element = 0;  ///< index of the law parameter, spring or mass
  std::string unit;
  double value = 0.0;  ///< as the case gives it
};

/// "connector.parameter", "substructure.spring.stiffness", "substructure.spring.damping" or "substructure.dof.mass".
/// Nothing where there is no such parameter.
std::optional<ParameterReference> find_parameter(const StructureParts& parts, const std::string& name);

/// All names that find_parameter() knows.
std::vector<std::string> parameter_names(const StructureParts& parts);

/// Whether a connector can carry an element's departure from a value: not that of a mass over an accelerated base,
/// which pulls at the mass in the linear part's coordinates, relative to the base.
bool can_be_released(const StructureParts& parts, const ParameterReference& element);

/// Whether damping of the linear part depends on a parameter that a connector carries: modal and Rayleigh damping of
/// its substructure follow the stiffness of a spring and a mass, damping of the whole structure's modes every element
/// and every law that is stiffer at rest with it.
bool linear_part_follows(const StructureParts& parts, const ParameterReference& element);

/// Sets an element or a connector's parameter.
void set_parameter(StructureParts& parts, const ParameterReference& element, double value);

/// Makes an element of a linear substructure a connector parameter: its value in the substructure becomes `nominal`,
/// and a connector that carries the departure from it is added at the same place. Returns the reference to that
/// connector's parameter. Masses hang on the inertial frame, a substructure of no degree of freedom that is added when
/// needed.
ParameterReference release_linear_element(StructureParts& parts, const ParameterReference& element, double nominal);

}  // namespace kalfem
