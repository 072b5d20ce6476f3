// SPDX-License-Identifier: Apache-2.0
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
  connector_rate,
  strain
};

/// Whether it is the motion of a point.
bool is_motion(ObservedQuantity quantity);
bool is_of_connector(ObservedQuantity quantity);

/// SI unit of a quantity.
std::string unit_of(ObservedQuantity quantity);

/// One observed quantity: at a point (absolute, or relative to the base), in a connector, or of a strain gauge.
struct OutputDescription {
  std::string name;
  ObservedQuantity quantity = ObservedQuantity::acceleration;
  DofCombination points;          ///< sum of coefficient times quantity, by qualified point, connector or gauge
  bool relative_to_base = false;  ///< with base_acceleration inputs: leave the base's own motion out
  /// Masses [kg] between a load cell and the connectors whose force it measures: mass times acceleration of each point
  /// is measured too.
  DofCombination carried_masses = {};
};

}  // namespace kalfem
