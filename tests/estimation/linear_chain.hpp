// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/chain_model.hpp"

namespace kalfem {

/// Wheel and two masses with two linear connectors, on a moving ground: what a Kalman filter solves exactly.
struct LinearChainModel {
  static constexpr double h = 2e-3;  ///< sample interval [s]
  CoupledModel model = quarter_chain(2,
                                     {{"strut", "wheel.w", "body.1", make_law("linear"), values({5e3, 20.0})},
                                      {"tie", "wheel.ground", "body.2", make_law("linear"), values({800.0, 3.0})}},
                                     {{"road", InputKind::base_displacement, "wheel.ground"}});
  OutputMap sensors = make_outputs(
      model,
      {Chain::acceleration("1"), Chain::acceleration("2"), {"d", ObservedQuantity::displacement, {{"body.1", 1.0}}}});
};

}  // namespace kalfem
