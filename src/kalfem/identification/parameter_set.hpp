// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/identification/structure.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// A parameter of a connector's law, by its position among these.
struct ConnectorParameter {
  Eigen::Index position = 0;
};

/// One number of a structure by its name, "owner.number": "suspension.mu_k1", "body.3-4.stiffness",
/// "frame.steel.youngs_modulus", "body.damping.modal.1". Everything that varies a structure names it by these.
struct Parameter {
  std::string name;
  std::string owner;  ///< the connector or the linear substructure
  std::string unit;
  double value = 0.0;  ///< in the structure as given
  std::variant<ConnectorParameter, LumpedParameter, FiniteElementParameter> where;

  [[nodiscard]] bool of_connector() const { return std::holds_alternative<ConnectorParameter>(where); }
};

/// theta[index] is the value of a parameter.
using StructureBinding = ParameterBinding<Parameter>;

/// Every parameter of a structure.
class ParameterSet {
public:
  explicit ParameterSet(const StructureModel& structure);

  /// Empty if there is none with that name.
  [[nodiscard]] std::optional<Parameter> find(const std::string& name) const;
  /// All names, including section parameters of beams, which exist only on request.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

private:
  std::vector<Parameter> parameters_;
  std::vector<std::string> names_;
};

/// Sets a parameter of a connector or of a lumped substructure. Says whether the parts have its owner; numbers of
/// finite elements are set with their matrices (ParameterisedStructure).
bool set_parameter(StructureParts& parts, const Parameter& parameter, double value);

}  // namespace kalfem
