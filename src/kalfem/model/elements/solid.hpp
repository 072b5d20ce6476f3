#pragma once

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Solid element of any shape through `nodes` [m], 3 x nodes, with the motions [x y z] of each node:
///     K = int B^T D B dV,   M = rho int N^T N dV,   D isotropic of E = 1 and nu, or the property's elasticity.
///
/// What the kinds are for each shape (points of the stiffness in brackets, see integration_rule()):
///
///     shape          standard                  full         mean_dilatation  reduced
///     tetrahedron4   (1)                       as standard  as standard      as standard
///     tetrahedron10  (4)                       as standard  as standard      as standard
///     wedge6         enhanced strains (3 x 2)  (3 x 2)      B-bar (3 x 2)    (1 x 2); 1 motion without stiffness
///     wedge15        (3 x 3)                   (3 x 3)      as full          (3 x 2); 3 motions without stiffness
///     hexahedron8    enhanced strains (2^3)    (2^3)        B-bar (2^3)      mean strains, hourglass stabilised
///     hexahedron20   (2^3), stabilised         (3^3)        as full          (2^3); 6 motions without stiffness
///
/// Motions without stiffness are those of a single free element beside the six rigid ones; a mesh more than one element
/// wide holds most of them, one row of elements does not. All kinds are exact in constant strain, on distorted elements
/// too. tetrahedron4 is stiff in bending and locks where nu comes near 1/2, wedge6 in its triangle likewise: the
/// quadratic shapes are meant for those. enhanced_stiffness(), one_point_hexahedron_stiffness() and
/// stabilised_stiffness() say what stands behind the others.
///
/// The order of the nodes is that of Abaqus and CalculiX for all six shapes. Their types, by comparison with CalculiX
/// 2.20 (displacements of distorted blocks under load are equal to 1e-6 where no difference is named):
///
///     C3D4, C3D10  any kind
///     C3D6         reduced
///     C3D8         full in CalculiX, which has no B-bar there; mean_dilatation is what Abaqus documents
///     C3D8I        standard, equal to 1 % in statics: CalculiX leaves out the three volume changes and the factor
///                  j0 / j of the enhanced strains, and fails the patch test; it also gives its inner motions mass
///     C3D8R        reduced, with the same mean strains, but CalculiX's hourglass stiffness is much softer
///     C3D15, C3D20 full
///     C3D20R       reduced
///
/// CalculiX integrates the mass with the points of the stiffness, here it is exact for straight sides: frequencies of
/// coarse meshes differ by that (C3D8 and C3D20 by nothing that matters).
///
/// Stiffness: one term E, or, where the property gives the elasticity, one without powers. Mass: one term rho; lumped:
/// its diagonal, scaled to the element's mass [HRZ76].
/// Throws ElementShapeError for a shape that is no solid, a wrong number of nodes, coordinates that are not finite,
/// nodes that coincide and a geometry that is flat, folded or inside out; InvalidInput for an elasticity that is not
/// symmetric and positive definite.
ElementMatrices solid(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                      double poissons_ratio, MassKind mass_kind);

}  // namespace kalfem
