#pragma once

#include "kalfem/formats/abaqus/kinematics.hpp"

namespace kalfem::abaqus {

/// Axes of nodes that *TRANSFORM turns.
using NodeAxes = std::unordered_map<Index, Eigen::Matrix3d>;
NodeAxes read_transforms(PlacedDeck& deck);

void read_boundaries(PlacedDeck& deck, const NodeAxes& axes, Kinematics& motions);
void read_equations(PlacedDeck& deck, const NodeAxes& axes, Kinematics& motions);
void read_multi_point_constraints(PlacedDeck& deck, Kinematics& motions);
/// *RIGID BODY, *COUPLING, *KINEMATIC COUPLING, *DISTRIBUTING COUPLING.
void read_rigid_bodies(PlacedDeck& deck, Kinematics& motions);
void read_couplings(PlacedDeck& deck, Kinematics& motions);
/// *TIE: nodes of one surface follow the faces of another.
void read_ties(PlacedDeck& deck, const FiniteElementModel& model, Kinematics& motions);

}  // namespace kalfem::abaqus
