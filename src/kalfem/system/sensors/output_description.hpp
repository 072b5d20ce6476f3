#pragma once

#include <string>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// What a sensor sees before its measurement chain.
enum class ObservedQuantity {
  displacement,
  velocity,
  acceleration,
  connector_force,
  connector_deformation,
  connector_rate
};

/// SI unit of a quantity.
std::string unit_of(ObservedQuantity quantity);

/// One observed quantity: at a point (absolute, or relative to the base) or in a connector.
struct OutputDescription {
  std::string name;
  ObservedQuantity quantity = ObservedQuantity::acceleration;
  DofCombination points;          ///< sum of coefficient times quantity, by qualified point or by connector
  bool relative_to_base = false;  ///< with base_acceleration inputs: leave the base's own motion out
  /// Masses [kg] between a load cell and the connectors whose force it measures: mass times acceleration of each point
  /// is measured too.
  DofCombination carried_masses = {};
};

}  // namespace kalfem
