// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The parts of a structure, ready to be coupled. The filter releases elements from them and leaves parts out.
struct StructureParts {
  std::vector<LumpedSubstructure> substructures;
  std::vector<Substructure> finite_elements;  ///< as matrices, reduced or full
  std::vector<ConnectorDescription> connectors;
  std::vector<InputDescription> inputs;
  std::optional<GlobalModalDamping> damping = {};
  std::vector<SharedDof> shared = {};  ///< of the finite elements, where they are joined
};

/// Qualified names of all grounds.
std::vector<std::string> ground_names(const StructureParts& parts);

/// Assembles every substructure and couples. Throws InvalidInput with everything that does not fit.
CoupledModel couple(const StructureParts& parts);

/// A structure with its known excitation, as the library's own types.
struct StructureModel {
  StructureParts parts;                                    ///< its finite-element substructures reduced
  std::vector<FiniteElementSubstructure> finite_elements;  ///< in the order of parts.finite_elements
  std::vector<SignalPtr> signals;                          ///< one an input of the parts

  /// The finite-element substructures as the filter's model holds them: reduced where they are.
  [[nodiscard]] std::vector<Substructure> reduced_parts() const;
  /// The parts that a record is simulated from: finite elements at full order, or as their reference superelements.
  [[nodiscard]] StructureParts reference_parts() const;
};
using StructurePtr = std::shared_ptr<const StructureModel>;

}  // namespace kalfem
