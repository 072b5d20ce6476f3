#pragma once

#include "kalfem/model/elements/solid_geometry.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Isotropic elasticity per unit Young's modulus,
///     D = lambda 1 1^T + 2 mu I,  2 mu = 1 / (1 + nu),  lambda = 2 mu nu / (1 - 2 nu).
Matrix6 isotropic_elasticity(double poissons_ratio);

/// Stiffness of the interpolated displacements, K = sum_p B_p^T D B_p V_p over the points.
Eigen::MatrixXd displacement_stiffness(const std::vector<SolidPoint>& points, const Matrix6& elasticity);

/// The same with the volume change of every point replaced by its mean over the element (B-bar [Hug80]).
Eigen::MatrixXd mean_dilatation_stiffness(const std::vector<SolidPoint>& points, const Matrix6& elasticity);

/// Stiffness of fewer points, in which a small part of the elasticity is integrated with all of them,
///     K = sum_few B^T (D - d m I) B V + sum_all B^T (d m I) B V,
/// m the softest modulus of D (least eigenvalue of stress per strain; 2 G of common isotropic materials), d = 0.02. The
/// six motions of a hexahedron20 that eight points do not see get 0.02 of the stiffness that they would have: in a free
/// element frequencies of a fifth of its first elastic one. The locking of all the points comes back by that part only,
/// and that of volume not at all.
Eigen::MatrixXd stabilised_stiffness(const std::vector<SolidPoint>& few, const std::vector<SolidPoint>& all,
                                     const Matrix6& elasticity);

}  // namespace kalfem
