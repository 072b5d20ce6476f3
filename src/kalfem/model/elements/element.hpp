#pragma once

#include <Eigen/Dense>
#include <stdexcept>
#include <string>
#include <vector>

namespace kalfem {

/// Powers of a region's properties that a matrix is proportional to.
struct PropertyPowers {
  int youngs_modulus = 0;
  int density = 0;
  int thickness = 0;
  friend auto operator<=>(const PropertyPowers&, const PropertyPowers&) = default;
};

/// One part of an element's matrix, per unit of the powers of its properties.
struct ElementTerm {
  PropertyPowers powers;
  Eigen::MatrixXd matrix;  ///< symmetric; 6 motions a node, 3 of a solid
};

/// Stiffness and mass of one element as sums over property groups,
///     K_e = sum_i E^a_i rho^b_i t^c_i K_i,   M_e likewise,
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
