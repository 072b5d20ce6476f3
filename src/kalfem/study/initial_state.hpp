#pragma once

#include "kalfem/dynamics/trajectory.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Where a simulation of the case begins: at rest, or as the case says. Throws InvalidInput for degrees of freedom that
/// the model does not have.
InitialState initial_state(const Study& study, const CoupledModel& model);

}  // namespace kalfem
