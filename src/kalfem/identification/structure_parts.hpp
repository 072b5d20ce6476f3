#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"

namespace kalfem {

/// The parts of a structure, ready to be coupled. The filter releases elements from them and leaves parts out.
struct StructureParts {
  std::vector<LumpedSubstructure> substructures;
  std::vector<Substructure> finite_elements;  ///< as matrices, reduced or full
  std::vector<ConnectorDescription> connectors;
  std::vector<InputDescription> inputs;
  std::optional<GlobalModalDamping> damping = {};
};

/// Qualified names of all grounds.
std::vector<std::string> ground_names(const StructureParts& parts);

/// Assembles every substructure and couples. Throws InvalidInput with everything that does not fit.
CoupledModel couple(const StructureParts& parts);

}  // namespace kalfem
