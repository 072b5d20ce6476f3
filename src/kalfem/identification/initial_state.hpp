// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/trajectory.hpp"
#include "kalfem/system/coupling.hpp"

namespace kalfem {

/// Displacement [m] and velocity [m/s] of a degree of freedom.
struct PointStart {
  double displacement = 0.0, velocity = 0.0;
};
/// How a simulation starts, by degree of freedom; those that are not named are at rest.
using InitialMotion = Named<Located<PointStart>>;

/// The start of a model. Throws InvalidInput for degrees of freedom that it does not have.
InitialState initial_state(const InitialMotion& initial, const CoupledModel& model);

}  // namespace kalfem
