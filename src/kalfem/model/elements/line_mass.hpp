// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Mass along the line of a beam, local axes, per length; of a lumped mass what stands at one end.
struct LineMass {
  double amount = 0.0;                               ///< [kg/m], per unit density [m^2]
  Eigen::Vector2d place = Eigen::Vector2d::Zero();   ///< off the line, local y and z [m]
  double polar = 0.0;                                ///< second moment about its own axis, turns with the twist
  Eigen::Matrix2d rotary = Eigen::Matrix2d::Zero();  ///< second moments that turn with the slopes [theta_z, -theta_y]
};

/// Of a section, per unit density. Rotary inertia is that of the planes that are soft in shear.
LineMass mass_of(const BeamSection& section);

/// A field of acceleration along the line of a beam, linear in space; local axes.
struct LineField {
  Eigen::Matrix<double, 3, 2> at_ends = Eigen::Matrix<double, 3, 2>::Zero();  ///< of the line [m/s^2]
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();                         ///< [1/s^2]

  /// At a share of the line from its first end, and a place in the section, local y and z [m].
  [[nodiscard]] Eigen::Vector3d at(double share, const Eigen::Vector2d& place) const {
    return (1.0 - share) * at_ends.col(0) + share * at_ends.col(1) + gradient.rightCols<2>() * place;
  }
};

/// Motions [u v w theta_x theta_y theta_z] of the line at a section, from those of the line's ends.
using SectionMotions = Eigen::Matrix<double, 6, 12>;
/// [theta_z, -theta_y] of the same, as slopes of [v, w].
Eigen::Matrix<double, 2, 12> turns_of(const SectionMotions& section);

/// N^T m N of a section, which summed with its weights along the line is the consistent mass.
Eigen::Matrix<double, 12, 12> mass_at_section(const LineMass& mass, const SectionMotions& section);
/// N^T m a of a field at the share of the line where the section is; how it differs across the section, against the
/// rotary inertia, is left out.
Eigen::Matrix<double, 12, 1> forces_at_section(const LineMass& mass, const SectionMotions& section, double share,
                                               const LineField& field);

/// The mass that stands at an end (0, 1) of a line: with `lumped_inertia` it has the rotary inertia of its section too,
/// and half of what a rotation of the whole gets by diagonal scaling, m L^2 / 78.
Eigen::Matrix<double, 12, 12> mass_at_end(const LineMass& mass, int end, double length, LumpedInertia lumped_inertia);
Eigen::Matrix<double, 12, 1> forces_at_end(const LineMass& mass, int end, const LineField& field);

}  // namespace kalfem
