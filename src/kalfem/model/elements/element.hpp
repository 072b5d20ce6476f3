// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <stdexcept>
#include <string>
#include <vector>

namespace kalfem {

/// A part of a beam's stiffness that a dimensionless factor of its region multiplies, 1 as it is given.
enum class BeamPart {
  none,       ///< no factor
  axial,      ///< E A along the line of centroids
  bending_y,  ///< E I_y and the shear flexibility along z: bending in the local x-z plane
  bending_z,  ///< E I_z and the shear flexibility along y: bending in the local x-y plane
  bending,    ///< both planes together
  torsion,    ///< G J about the line of shear centres
  stiffness   ///< all of it
};
/// "bending_y"; "" for none.
const char* to_string(BeamPart part);

/// Powers of a region's properties that a matrix is proportional to.
struct PropertyPowers {
  int youngs_modulus = 0;
  int density = 0;
  int thickness = 0;
  BeamPart part = BeamPart::none;  ///< the first power of that part's factor
  friend auto operator<=>(const PropertyPowers&, const PropertyPowers&) = default;
};

/// One part of an element's matrix, per unit of the powers of its properties.
struct ElementTerm {
  PropertyPowers powers;
  Eigen::MatrixXd matrix;  ///< symmetric; 6 motions a node, 3 of a solid
};

/// Stiffness and mass of one element as sums over property groups,
///     K_e = sum_i E^a_i rho^b_i t^c_i f_i K_i,   M_e likewise, with the factor f_i of a beam's part,
/// in global axes with the degrees of freedom [x y z rx ry rz] of each node in turn ([x y z] of a solid). A term that
/// depends on a property otherwise than by these powers is formed at the property's present value.
struct ElementMatrices {
  std::vector<ElementTerm> stiffness;
  std::vector<ElementTerm> mass;
};

enum class MassKind { consistent, lumped };

/// The geometry of an element cannot be integrated; the assembly adds which element and where it stands.
class ElementShapeError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

}  // namespace kalfem
