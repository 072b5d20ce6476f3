#pragma once

#include <Eigen/Dense>
#include <string>
#include <variant>

#include "kalfem/model/elements/element.hpp"

namespace kalfem {

/// Linear elastic, the same in all directions.
struct IsotropicMaterial {
  double youngs_modulus = 0.0;  ///< E [Pa]
  double poissons_ratio = 0.3;  ///< nu [-], in (-1, 0.5)
  double density = 0.0;         ///< rho [kg/m^3]

  [[nodiscard]] double shear_modulus() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
};

/// Cross-section of a beam in its local y and z axes, through the centroid.
struct BeamSection {
  double area = 0.0;            ///< A [m^2]
  double inertia_y = 0.0;       ///< second moment about local y, of bending in the x-z plane [m^4]
  double inertia_z = 0.0;       ///< second moment about local z, of bending in the x-y plane [m^4]
  double torsion = 0.0;         ///< St Venant torsion constant J [m^4]
  double shear_factor_y = 0.0;  ///< shear area / A for forces along y; 0: shear rigid (Euler-Bernoulli)
  double shear_factor_z = 0.0;  ///< the same along z
};

// Sections of usual shape. Shear factors are Cowper's [Cow66] and depend a little on Poisson's ratio. All throw
// InvalidInput for lengths that are not positive and finite and for a wall that leaves no hole.

/// Solid rectangle; J by its Fourier series [TG70].
BeamSection rectangular_section(double width_y, double height_z, double poissons_ratio = 0.3);
/// Solid circle.
BeamSection circular_section(double diameter, double poissons_ratio = 0.3);
/// Circular tube of any wall.
BeamSection circular_tube_section(double outer_diameter, double wall, double poissons_ratio = 0.3);
/// Rectangular tube with sharp corners: A and I exact, J by Bredt's formula and the shear factors for a thin wall.
BeamSection rectangular_tube_section(double width_y, double height_z, double wall, double poissons_ratio = 0.3);

/// Thickness of a region of triangles and quadrilaterals.
struct ShellProperty {
  std::string material;
  double thickness = 0.0;  ///< t [m]
};

/// Section of a region of lines. Local x runs from the first node to the second, local z is `up` made normal to x, and
/// y completes the right-handed axes.
struct BeamProperty {
  std::string material;
  BeamSection section;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();     ///< local z lies in the plane of x and up, on the side of up
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< centroid minus node, both ends, global axes [m]
};

using RegionProperty = std::variant<ShellProperty, BeamProperty>;

}  // namespace kalfem
