#pragma once

#include <memory>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/identification/structure_parts.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

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
