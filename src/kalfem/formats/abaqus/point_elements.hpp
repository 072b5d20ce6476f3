#pragma once

#include "kalfem/formats/abaqus/kinematics.hpp"

namespace kalfem::abaqus {

/// SPRING1, SPRING2, SPRINGA and DASHPOT1, DASHPOT2, DASHPOTA with their *SPRING and *DASHPOT.
void add_springs(PlacedDeck& deck, FiniteElementModel& model);
/// MASS and ROTARYI with their *MASS and *ROTARY INERTIA.
void add_masses(PlacedDeck& deck, FiniteElementModel& model);
/// *NONSTRUCTURAL MASS, as masses at nodes. The regions must be there.
void add_nonstructural_masses(PlacedDeck& deck, FiniteElementModel& model);
/// *MATRIX ASSEMBLE of CalculiX: lines "node, direction, node, direction, value" of one triangle.
void add_matrices(const RawDeck& raw, PlacedDeck& deck, FiniteElementModel& model);

}  // namespace kalfem::abaqus
