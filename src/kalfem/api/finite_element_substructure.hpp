// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/api/finite_elements.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// The points and parameters of a finite-element substructure that the rest of the structure uses.
struct ElementsInUse {
  std::vector<std::string> attached;    ///< its points that connectors and forces touch, without its name
  std::vector<std::string> parameters;  ///< that vary, without its name
  double sensor_bandwidth = std::numeric_limits<double>::infinity();  ///< [Hz]
};

/// Gives one of the substructure's numbers another value, "steel.youngs_modulus" or "damping.modal".
void set_number(FiniteElements& substructure, const std::string& number, double value);

/// Assembles the substructure and reduces it where it was told to. Throws InvalidInput with its name.
FiniteElementSubstructure make_substructure(const FiniteElements& given, const ElementsInUse& use);

/// The substructure assembled at full order. Throws InvalidInput with its name.
FiniteElementPart make_full_part(const FiniteElements& given);

}  // namespace kalfem
