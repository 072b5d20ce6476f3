// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/identification/parameter_set.hpp"

namespace kalfem {

/// Whether a connector of the parts can carry a parameter: it is one of a connector's law, or a spring, dashpot or mass
/// of a lumped substructure; not a mass over an accelerated base, which pulls at the mass in the linear part's
/// coordinates, relative to the base.
bool can_be_released(const StructureParts& parts, const Parameter& parameter);

/// Whether damping of the linear part depends on a parameter that a connector carries: modal and Rayleigh damping of
/// its substructure follow the stiffness of a spring and a mass, damping of the whole structure's modes every element
/// and every law that is stiffer at rest with it.
bool linear_part_follows(const StructureParts& parts, const Parameter& parameter);

/// Whether it is a spring's stiffness or a mass, which are positive by nature: sigma points near a stiffness of zero
/// would pull the first estimates away. A dashpot may be nothing, and a law's parameter of either sign.
bool is_positive_by_nature(const Parameter& parameter);

/// Makes a parameter one of a connector. That of a law is one already. An element of a linear substructure keeps the
/// value `nominal` there, and a connector that carries the departure from it is added at the same place; masses hang on
/// the inertial frame, a substructure of no degree of freedom that is added when needed.
ParameterTarget release(StructureParts& parts, const Parameter& parameter, double nominal);

}  // namespace kalfem
