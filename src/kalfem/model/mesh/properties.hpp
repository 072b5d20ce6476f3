// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/model/elements/element.hpp"

namespace kalfem {

/// What a modulus, a thickness or a mass has to be; not true of NaN and infinity.
inline bool is_positive(double value) { return value > 0.0 && std::isfinite(value); }

/// Linear elastic, the same in all directions.
struct IsotropicMaterial {
  double youngs_modulus = 0.0;  ///< E [Pa]
  double poissons_ratio = 0.3;  ///< nu [-], in (-1, 0.5)
  double density = 0.0;         ///< rho [kg/m^3]

  [[nodiscard]] double shear_modulus() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
};

/// Where the axial stress of a section is largest: its corners, or the radius of a round one, from the centroid.
/// Neither where the section is known by its constants alone.
struct SectionOutline {
  std::vector<Eigen::Vector2d> corners = {};  ///< local y and z [m]
  double radius = 0.0;                        ///< [m]
};

/// Cross-section of a beam in its local y and z axes. Axial force acts at the centroid, shear and torsion at the shear
/// centre, which is the beam's line.
struct BeamSection {
  double area = 0.0;            ///< A [m^2]
  double inertia_y = 0.0;       ///< second moment about local y through the centroid, of bending in the x-z plane [m^4]
  double inertia_z = 0.0;       ///< second moment about local z, of bending in the x-y plane [m^4]
  double torsion = 0.0;         ///< St Venant torsion constant J [m^4]
  double shear_factor_y = 0.0;  ///< shear area / A for forces along y; 0: shear rigid (Euler-Bernoulli)
  double shear_factor_z = 0.0;  ///< the same along z
  double product_yz = 0.0;      ///< product of inertia, integral of y z dA about the centroid [m^4]
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< of the section, from the shear centre: local y and z [m]
  SectionOutline outline = {};
};

// Sections of usual shape. Shear factors are Cowper's [Cow66] and depend a little on Poisson's ratio. All throw
// InvalidInput for lengths that are not positive and finite and for a wall that leaves no hole.

/// Solid rectangle; J by its Fourier series [TG70].
BeamSection rectangular_section(double width_y, double height_z, double poissons_ratio = 0.3);
/// Solid circle.
BeamSection circular_section(double diameter, double poissons_ratio = 0.3);
/// Circular tube of any wall.
BeamSection circular_tube_section(double outer_diameter, double wall, double poissons_ratio = 0.3);
/// Rectangular tube with sharp corners: A and I exact, J by box_torsion() and the shear factors for a thin wall.
BeamSection rectangular_tube_section(double width_y, double height_z, double wall, double poissons_ratio = 0.3);

/// Torsion constant of a box of thin walls of any thickness t, between the middles of its corners l long:
///     J = 4 A_m^2 / sum(l / t) + sum(l t^3) / 3,   A_m = width * height
/// Bredt's closed part, and that of the walls alone, which is all that stays where one of them is slit [TG70].
/// `along_width`: walls at the bottom and the top, `along_height` at the left and the right [m].
double box_torsion(double width, double height, const std::array<double, 2>& along_width,
                   const std::array<double, 2>& along_height);

/// Thickness of a region of triangles and quadrilaterals.
struct ShellProperty {
  std::string material;
  double thickness = 0.0;           ///< t [m]
  double offset = 0.0;              ///< mid-surface above the nodes, along the normal by the right-hand rule [m]
  double nonstructural_mass = 0.0;  ///< beside rho t [kg/m^2]
};

/// Resultants of a shell's cross-section: n = A e + B k, m = B e + D k, q = S g with the strains e of the mid-surface,
/// its curvatures k and transverse shear g, [xx yy xy] each.
struct ShellStiffness {
  Eigen::Matrix3d membrane = Eigen::Matrix3d::Zero();  ///< A [N/m]
  Eigen::Matrix3d coupling = Eigen::Matrix3d::Zero();  ///< B [N]
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();   ///< D [N m]
  Eigen::Matrix2d shear = Eigen::Matrix2d::Zero();     ///< S of [xz yz] [N/m]
};

/// A region of triangles and quadrilaterals of any cross-section: layers, sandwiches, plates with bending stiffness of
/// their own. Not affine in a material: its matrices are at their present values.
struct LaminateProperty {
  ShellStiffness stiffness;
  double mass = 0.0;            ///< [kg/m^2]
  double rotary_inertia = 0.0;  ///< about the mid-surface [kg]
  double offset = 0.0;          ///< as of ShellProperty [m]
  std::vector<Eigen::Vector3d> directions =
      {};  ///< x axis of the stiffness, laid into the surface: one for all cells, or one each; none: the first side

  [[nodiscard]] Eigen::Vector3d direction(std::size_t cell) const {
    if (directions.empty()) return Eigen::Vector3d::Zero();
    return directions.size() == 1 ? directions.front() : directions[cell];
  }
};

/// How a beam lies between its nodes. Local x runs from the first end of the beam's line to the second, local z is `up`
/// made normal to x, and y completes the right-handed axes.
struct BeamPlacement {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< local z lies in the plane of x and up, on the side of up
  Eigen::Matrix<double, 3, 2> offsets =
      Eigen::Matrix<double, 3, 2>::Zero();  ///< beam's line minus node at each end, global axes [m]
  std::array<bool, 12> released = {};       ///< hinges: local motions of the ends that carry no force
};

/// What a beam has at one place of its line.
struct BeamStation {
  double place = 0.0;  ///< share of the line from its first end, 0 to 1
  BeamSection section;
  double nonstructural_mass = 0.0;     ///< [kg/m]
  double nonstructural_inertia = 0.0;  ///< of that mass about its centre, as the section twists [kg m]
  Eigen::Vector2d nonstructural_centre = Eigen::Vector2d::Zero();  ///< from the shear centre: local y, z [m]
};

/// Which rotations of its ends have inertia where the mass of a beam is lumped, beside that of masses off the line.
enum class LumpedInertia {
  all,    ///< twist and bending
  twist,  ///< as CBEAM of Nastran
  none    ///< as CBAR and the rods of Nastran
};

/// Section of a region of lines.
struct BeamProperty {
  std::string material;
  BeamSection section;                                             ///< of a tapered beam the mean over its length
  std::vector<BeamPlacement> placements = {BeamPlacement{}};       ///< one for all cells of the region, or one each
  double nonstructural_mass = 0.0;                                 ///< beside rho A [kg/m]
  Eigen::Vector2d nonstructural_centre = Eigen::Vector2d::Zero();  ///< of it, from the shear centre: local y, z [m]
  /// Of a tapered beam, which is linear between them, by ascending place, the first at 0 and the last at 1.
  std::vector<BeamStation> stations = {};
  LumpedInertia lumped_inertia = LumpedInertia::all;

  [[nodiscard]] const BeamPlacement& placement(std::size_t cell) const {
    return placements.size() == 1 ? placements.front() : placements[cell];
  }
};

/// How the strains of a solid are integrated.
enum class SolidKind {
  standard,  ///< free of locking: enhanced strains in the 8-node hexahedron and the wedge, reduced in the 20-node one
  full,      ///< the plain displacement element
  mean_dilatation,  ///< full, with the volume change of the whole element (B-bar): 8-node hexahedron
  reduced  ///< fewer points: 20-node hexahedron, 15-node wedge; 8-node hexahedron with its hourglass stabilised
};

/// Stress per strain, [xx yy zz xy yz xz] with engineering shear strains.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// In global axes what is given in local ones, the columns of `axes`: R^T D R with the local strains R e of global
/// ones.
Matrix6 in_global_axes(const Matrix6& elasticity, const Eigen::Matrix3d& axes);

/// A region of tetrahedra, wedges and hexahedra.
struct SolidProperty {
  std::string material;
  SolidKind kind = SolidKind::standard;
  std::optional<Matrix6> elasticity =
      {};  ///< in global axes [Pa]; instead of the material's E and nu, not affine in them
};

using RegionProperty = std::variant<ShellProperty, LaminateProperty, BeamProperty, SolidProperty>;

/// Name of the material, "" of a laminate, which has none of its own.
std::string material_of(const RegionProperty& property);
/// Motions of a node that elements of the property join: 3 of a solid, else 6.
int motions_per_node(const RegionProperty& property);

}  // namespace kalfem
