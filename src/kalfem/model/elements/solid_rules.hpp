#pragma once

#include <vector>

#include "kalfem/model/elements/solid_shapes.hpp"

namespace kalfem {

/// A point of an integration rule in natural coordinates, with the shape functions there.
struct IntegrationPoint {
  Eigen::Vector3d place;
  double weight = 0.0;
  ShapeFunctions functions;
};

using IntegrationRule = std::vector<IntegrationPoint>;

/// What a rule is for.
enum class RulePurpose {
  strain,          ///< stiffness: enough points that nothing but a rigid motion is free of strain
  reduced_strain,  ///< stiffness with fewer points
  mass,            ///< exact for the mass of straight-sided elements
  corners          ///< the corners, without weight: to look at the shape there
};

/// Rules by shape. Points along r, s and t of a hexahedron, in the triangle and along t of a wedge:
///
///     shape          strain        reduced_strain   mass
///     tetrahedron4   1             1                4
///     tetrahedron10  4             4                15
///     wedge6         3 x 2         1 x 2            7 x 3
///     wedge15        3 x 3         3 x 2            7 x 4
///     hexahedron8    2 x 2 x 2     1                3 x 3 x 3
///     hexahedron20   3 x 3 x 3     2 x 2 x 2        4 x 4 x 4
///
/// Gauss points along lines; triangles and tetrahedra of degree 1, 2 and 5 [Str71]. Computed once.
const IntegrationRule& integration_rule(CellShape shape, RulePurpose purpose);

}  // namespace kalfem
