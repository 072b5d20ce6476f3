#pragma once

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// The axes of *ORIENTATION, NAME=name as a keyword at `where` in a place uses them; global axes and a problem where
/// they cannot be had.
LocalAxes orientation_axes(PlacedDeck& deck, const std::string& name, int place, const Where& where);

/// The axes of *TRANSFORM.
LocalAxes transform_axes(PlacedDeck& deck, const PlacedBlock& transform);

/// Local direction 1 of a shell in axes of an orientation: the axis behind the one that the orientation is turned
/// about, laid into the surface.
Eigen::Vector3d shell_direction(const LocalAxes& axes, const Eigen::Vector3d& place, const Eigen::Vector3d& normal);
/// The same without an orientation: global x laid into the surface, z where x is within 0.1 degrees of the normal.
Eigen::Vector3d shell_direction(const Eigen::Vector3d& normal);

}  // namespace kalfem::abaqus
