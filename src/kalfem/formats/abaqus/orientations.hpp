// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <numbers>
#include <optional>
#include <string>

#include "kalfem/formats/abaqus/deck_lines.hpp"

namespace kalfem::abaqus {

class PlacedDeck;
struct PlacedBlock;

inline constexpr double degree = std::numbers::pi / 180.0;  ///< [rad]

/// Right-handed orthonormal axes as columns: x along the first vector, y in the plane of both on the side of the
/// second; nothing where they lie on one line.
std::optional<Eigen::Matrix3d> axes_from(const Eigen::Vector3d& x, const Eigen::Vector3d& in_plane);

/// Rotation by an angle [rad] about a unit vector.
Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, double angle);

enum class AxesKind { rectangular, cylindrical, spherical };

/// Local axes that may differ from place to place.
struct LocalAxes {
  AxesKind kind = AxesKind::rectangular;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< of a rectangular system; z of a cylindrical one
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  int rotated_axis = 0;  ///< 0, 1, 2: further turned about this one of its axes
  double angle = 0.0;    ///< [rad]

  /// Columns are the local axes at a place, in global components: radial, tangential and axial of a cylindrical
  /// system; radial, circumferential and meridional of a spherical one. On the axis the radial one is any.
  [[nodiscard]] Eigen::Matrix3d at(const Eigen::Vector3d& place) const;
};

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
