// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/elements/solid.hpp"

namespace kalfem {

/// Strains [xx yy zz xy yz xz] of a solid in global axes, engineering shear, 6 x places.
using SolidStrains = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The solid with the same corners and no other nodes.
CellShape linear_shape(CellShape shape);

/// Strains at the nodes of an element and, in a last column, at its centre, under the displacements [x y z] of each
/// node in turn [m].
///
/// The strains are those that the stiffness of the property's kind rests on, with the enhanced strains and the mean
/// dilatation where the kind has them, sampled at its integration points, which are the best places (reduced points of
/// the hexahedron20 [Bar76]). From there a field that is linear along the sides between the corners is fitted by least
/// squares: exact where there are as many points as corners, constant along an axis with one point.
/// Constant strain is exact for any shape.
/// Throws ElementShapeError as solid() does.
SolidStrains solid_strains(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                           double poissons_ratio, const Eigen::VectorXd& displacements);

}  // namespace kalfem
