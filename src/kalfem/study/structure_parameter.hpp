#pragma once

#include <string>
#include <variant>

#include "kalfem/model/assembly/finite_element_parameters.hpp"

namespace kalfem {

/// A parameter of a linear substructure by its name, "substructure.parameter".
struct StructureParameter {
  std::string name;  ///< with the substructure's
  std::string substructure;
  std::variant<LumpedParameter, FiniteElementParameter> target;
  std::string unit;
  double value = 0.0;  ///< as the case gives it
};

/// theta[index] is the value of a parameter.
using StructureBinding = ParameterBinding<StructureParameter>;

}  // namespace kalfem
