// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "kalfem/model/elements/shell_strains.hpp"

namespace kalfem {
namespace {

using Plane = Eigen::Matrix<double, 2, 3>;  ///< corners in the plane of the triangle
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix11 = Eigen::Matrix<double, 11, 11>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;
using FlexureRow = Eigen::Matrix<double, 1, 11>;  ///< per [w b_x b_y] of each corner, then b_x b_y of the bubble

/// A flat triangle in its own axes.
struct Triangle {
  Eigen::Matrix3d axes;  ///< rows: x and y of the section, normal
  Plane corners;
  double area = 0.0;
  DrillingOptions drilling;

  /// Side a - b as a vector.
  [[nodiscard]] Eigen::Vector2d side(int a, int b) const { return corners.col(a) - corners.col(b); }
};

/// Its first axis along `direction`, or along the first side where that is zero.
Triangle triangle_through(const Eigen::Matrix3d& corners, const Eigen::Vector3d& direction,
                          const DrillingOptions& drilling) {
  require_distinct(corners);
  const Eigen::Vector3d first = corners.col(1) - corners.col(0), second = corners.col(2) - corners.col(0);
  const Eigen::Vector3d twice_area = first.cross(second);
  const double longest = std::max({first.norm(), second.norm(), (second - first).norm()});
  if (!(twice_area.norm() > 1e-10 * longest * longest))
    throw ElementShapeError("its area is zero: its corners lie on one line");
  Triangle triangle;
  triangle.drilling = drilling;
  triangle.area = 0.5 * twice_area.norm();
  const Eigen::Vector3d normal = twice_area.normalized();
  triangle.axes.row(0) = axis_in_surface(direction, first, normal);
  triangle.axes.row(2) = normal;
  triangle.axes.row(1) = Eigen::Vector3d(triangle.axes.row(2)).cross(Eigen::Vector3d(triangle.axes.row(0)));
  triangle.corners = triangle.axes.topRows<2>() * (corners.colwise() - corners.col(0));
  return triangle;
}

/// Rows: the strain along the sides 1-2, 2-3, 3-1 from [xx, yy, 2 xy].
Eigen::Matrix3d strains_along_sides(const Triangle& triangle) {
  Eigen::Matrix3d along;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d side = triangle.side((i + 1) % 3, i).normalized();
    along.row(i) << side.x() * side.x(), side.y() * side.y(), side.x() * side.y();
  }
  return along;
}

/// Nodal forces of a unit constant membrane stress times the thickness; L^T u / A is the mean strain of the motion u.
/// The normal force per length s along a side brings the moments -bulge s and bulge s to its ends, unless it is
/// straight.
Eigen::Matrix<double, 9, 3> lumping(const Triangle& triangle) {
  Eigen::Matrix<double, 9, 3> forces = Eigen::Matrix<double, 9, 3>::Zero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Eigen::Vector2d opposite = triangle.side(j, k), next = triangle.side(j, i);
    forces.row(3 * i) << 0.5 * opposite.y(), 0.0, -0.5 * opposite.x();
    forces.row(3 * i + 1) << 0.0, -0.5 * opposite.x(), 0.5 * opposite.y();
    if (triangle.drilling.straight[static_cast<std::size_t>(i)]) continue;
    const double length = next.norm();
    const Eigen::RowVector3d normal(next.y() * next.y(), next.x() * next.x(), -2.0 * next.x() * next.y());
    const Eigen::RowVector3d moment = bulge(length) / (length * length) * normal;
    forces.row(3 * i + 2) -= moment;
    forces.row(3 * j + 2) += moment;
  }
  return forces;
}

/// Drilling rotations of the corners beyond the turn of the triangle, 3 x 9.
Eigen::Matrix<double, 3, 9> hierarchical_rotations(const Triangle& triangle) {
  Eigen::Matrix<double, 3, 9> rotations;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d opposite = triangle.side((i + 2) % 3, (i + 1) % 3) / (4.0 * triangle.area);
    rotations.middleCols<3>(3 * i) << Eigen::Vector3d::Constant(opposite.x()), Eigen::Vector3d::Constant(opposite.y()),
        Eigen::Vector3d::Unit(i);
  }
  return rotations;
}

/// Strains along the sides 1-2, 2-3, 3-1 in the middle of side i - j that the hierarchical rotations bring [Fel03].
Eigen::Matrix3d bending_strains_along_sides(const Triangle& triangle, int i) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  Eigen::Matrix3d strains = Eigen::Matrix3d::Zero();
  strains(i, i) = -1.0, strains(i, j) = 1.0;
  strains(j, i) = 1.0, strains(j, j) = 2.0, strains(j, k) = 1.0;
  strains(k, i) = -2.0, strains(k, j) = -1.0, strains(k, k) = -1.0;
  for (int side = 0; side < 3; ++side)
    strains.row(side) *= triangle.area / (3.0 * triangle.side((side + 1) % 3, side).squaredNorm());
  return strains;
}

/// b_0, by which the linear membrane strains weigh, optimal for bending in the plane in the mean over all directions:
///     b_0 = max(256 det(A) / W - 3/2, 1/100)
/// with the invariant W of [Fel03]; (1 - 4 nu^2) / 2 of an isotropic membrane.
double linear_share(const Eigen::Matrix3d& a) {
  const double e11 = a(0, 0), e22 = a(1, 1), e33 = a(2, 2), e12 = a(0, 1), e13 = a(0, 2), e23 = a(1, 2);
  const double w = -6.0 * std::pow(e12, 3) + 5.0 * e11 * e11 * e22 - 5.0 * e12 * e12 * e22 -
                   e22 * (75.0 * e13 * e13 + 14.0 * e13 * e23 + 3.0 * e23 * e23) +
                   2.0 * e12 * (7.0 * e13 * e13 + 46.0 * e13 * e23 + 7.0 * e23 * e23) -
                   e11 * (5.0 * e12 * e12 + 3.0 * e13 * e13 - 6.0 * e12 * e22 - 5.0 * e22 * e22 + 14.0 * e13 * e23 +
                          75.0 * e23 * e23) +
                   (3.0 * e11 * e11 + 82.0 * e11 * e22 + 3.0 * e22 * e22 -
                    4.0 * (6.0 * e12 * e12 + 5.0 * e13 * e13 - 6.0 * e13 * e23 + 5.0 * e23 * e23)) *
                       e33 +
                   4.0 * (5.0 * e11 - 6.0 * e12 + 5.0 * e22) * e33 * e33;
  return std::max(256.0 * a.determinant() / w - 1.5, 0.01);
}

/// Strains that the hierarchical rotations bring in the middle of a side, per motion of the corners.
Eigen::Matrix<double, 3, 9> linear_strains(const Triangle& triangle, int side) {
  return strains_along_sides(triangle).inverse() * bending_strains_along_sides(triangle, side) *
         hierarchical_rotations(triangle);
}

/// [u_x u_y theta_z] of each corner: the optimal membrane triangle [Fel03],
///     K = L A L^T / area + 3/4 b_0 area T^T (sum over the sides of Q^T A_s Q) T,
/// which is exact for bending in the plane of two isotropic triangles that make a rectangle.
Matrix9 membrane_stiffness(const Triangle& triangle, const Eigen::Matrix3d& membrane) {
  const Eigen::Matrix<double, 9, 3> forces = lumping(triangle);
  Matrix9 stiffness = forces * membrane * forces.transpose() / triangle.area;
  const double share = 0.75 * linear_share(membrane) * triangle.area;
  for (int side = 0; side < 3; ++side) {
    const Eigen::Matrix<double, 3, 9> strains = linear_strains(triangle, side);
    stiffness += share * strains.transpose() * membrane * strains;
  }
  return stiffness;
}

/// Deflection w and turn b = theta x n of the normals, in natural coordinates r and s [LLB14]: w is linear, b linear
/// with the bubble 27 r s (1 - r - s) taken out of the corners' shares and given to the fourth node.
class Flexure {
public:
  explicit Flexure(const Triangle& triangle) : triangle_(triangle) {
    jacobian_ << triangle.side(1, 0), triangle.side(2, 0);
    slopes_ = jacobian_.inverse().transpose();
  }

  /// Curvatures [b_x,x, b_y,y, b_x,y + b_y,x].
  [[nodiscard]] Eigen::Matrix<double, 3, 11> curvatures(double r, double s) const {
    const Eigen::Vector2d bubble = 27.0 * slopes_ * Eigen::Vector2d(s * (1.0 - 2.0 * r - s), r * (1.0 - r - 2.0 * s));
    Eigen::Matrix<double, 3, 11> curvatures = Eigen::Matrix<double, 3, 11>::Zero();
    for (int node = 0; node < 4; ++node) {
      const Eigen::Vector2d slope = node < 3 ? Eigen::Vector2d(slopes_ * corner_slope(node) - bubble / 3.0) : bubble;
      curvatures.middleCols<2>(first_turn(node)) << slope.x(), 0.0, 0.0, slope.y(), slope.y(), slope.x();
    }
    return curvatures;
  }

  /// [2 xz, 2 yz] of the assumed transverse shear, linear in r and s:
  ///     e_r = 2/3 (e_r - e_s / 2)^B + 1/3 (e_r + e_s)^C + c (3 s - 1) / 3,   c = e_r^F - e_r^D - e_s^F + e_s^E,
  ///     e_s = 2/3 (e_s - e_r / 2)^A + 1/3 (e_r + e_s)^C + c (1 - 3 r) / 3.
  [[nodiscard]] Eigen::Matrix<double, 2, 11> assumed_shear(double r, double s) const {
    // D, E and F stand off the centre by this little, so that the turn about the normal meets almost no shear.
    constexpr double d = 1e-4, third = 1.0 / 3.0;
    const Shear a = shear(1.0 / 6.0, 2.0 / 3.0), b = shear(2.0 / 3.0, 1.0 / 6.0), c = shear(1.0 / 6.0, 1.0 / 6.0);
    const Shear at_d = shear(third + d, third - 2.0 * d), at_e = shear(third - 2.0 * d, third + d),
                at_f = shear(third + d, third + d);
    const FlexureRow both = third * (c.row(0) + c.row(1));
    const FlexureRow twist = third * (at_f.row(0) - at_d.row(0) - at_f.row(1) + at_e.row(1));
    Shear strains;
    strains << 2.0 * third * (b.row(0) - 0.5 * b.row(1)) + both + (3.0 * s - 1.0) * twist,
        2.0 * third * (a.row(1) - 0.5 * a.row(0)) + both + (1.0 - 3.0 * r) * twist;
    return slopes_ * strains;
  }

private:
  using Shear = Eigen::Matrix<double, 2, 11>;

  static int first_turn(int node) { return node < 3 ? 3 * node + 1 : 9; }
  static Eigen::Vector2d corner_slope(int corner) {
    return corner == 0 ? Eigen::Vector2d(-1.0, -1.0) : Eigen::Vector2d(Eigen::Vector2d::Unit(corner - 1));
  }
  /// Interpolated [2 e_rt, 2 e_st] = w,a + b . x,a.
  [[nodiscard]] Shear shear(double r, double s) const {
    const double bubble = 27.0 * r * s * (1.0 - r - s);
    const Eigen::Vector3d linear(1.0 - r - s, r, s);
    Shear strains = Shear::Zero();
    for (int corner = 0; corner < 3; ++corner) strains.col(3 * corner) = corner_slope(corner);
    for (int node = 0; node < 4; ++node)
      strains.middleCols<2>(first_turn(node)) =
          (node < 3 ? linear[node] - bubble / 3.0 : bubble) * jacobian_.transpose();
    return strains;
  }

  Triangle triangle_;
  Eigen::Matrix2d jacobian_;  ///< x,r and x,s
  Eigen::Matrix2d slopes_;    ///< from slopes along r and s to those along x and y
};

struct GaussPoint {
  double r, s, weight;
};

/// Radon's rule, exact to the fifth degree; weights sum to 1.
std::array<GaussPoint, 7> gauss_points() {
  const double root = std::sqrt(15.0);
  const double a = (6.0 - root) / 21.0, b = (6.0 + root) / 21.0;
  const double near_side = (155.0 - root) / 1200.0, near_corner = (155.0 + root) / 1200.0;
  return {GaussPoint{1.0 / 3.0, 1.0 / 3.0, 9.0 / 40.0},
          {a, a, near_side},
          {1.0 - 2.0 * a, a, near_side},
          {a, 1.0 - 2.0 * a, near_side},
          {b, b, near_corner},
          {1.0 - 2.0 * b, b, near_corner},
          {b, 1.0 - 2.0 * b, near_corner}};
}

/// With the motions of the bubble.
Matrix11 full_flexure_stiffness(const Flexure& flexure, double area, const ShellStiffness& section) {
  Matrix11 stiffness = Matrix11::Zero();
  for (const auto& [r, s, weight] : gauss_points()) {
    const auto curvatures = flexure.curvatures(r, s);
    const auto sheared = flexure.assumed_shear(r, s);
    stiffness +=
        weight * area *
        (curvatures.transpose() * section.bending * curvatures + sheared.transpose() * section.shear * sheared);
  }
  return stiffness;
}

/// Turns of the bubble that carry no moment, per motion of the corners.
Eigen::Matrix<double, 2, 9> bubble_turns(const Matrix11& stiffness) {
  return -stiffness.bottomRightCorner<2, 2>().inverse() * stiffness.bottomLeftCorner<2, 9>();
}

/// [w b_x b_y] of each corner, the bubble condensed.
Matrix9 flexure_stiffness(const Triangle& triangle, const ShellStiffness& section) {
  const Matrix11 stiffness = full_flexure_stiffness(Flexure(triangle), triangle.area, section);
  return stiffness.topLeftCorner<9, 9>() + stiffness.topRightCorner<9, 2>() * bubble_turns(stiffness);
}

/// Membrane motions x flexural ones: area (mean strain)^T B (mean curvature), to which the bubble adds nothing.
Matrix9 coupling_stiffness(const Triangle& triangle, const Eigen::Matrix3d& coupling) {
  Eigen::Matrix<double, 3, 11> curvatures = Eigen::Matrix<double, 3, 11>::Zero();
  const Flexure flexure(triangle);
  for (const auto& [r, s, weight] : gauss_points()) curvatures += weight * flexure.curvatures(r, s);
  return lumping(triangle) * coupling * curvatures.leftCols<9>();
}

/// [u_x u_y theta_z] of the corners in the triangle's axes from global displacements and rotations; the drilling
/// rotation of a corner that follows is the turn of the triangle, sum_j (x_j+1 - x_j-1) . u_j / (4 area).
Eigen::Matrix<double, 9, 18> to_membrane(const Triangle& triangle) {
  Eigen::Matrix<double, 9, 18> map = Eigen::Matrix<double, 9, 18>::Zero();
  for (int i = 0; i < 3; ++i) {
    map.block<2, 3>(3 * i, 6 * i) = triangle.axes.topRows<2>();
    if (!triangle.drilling.following[static_cast<std::size_t>(i)])
      map.block<1, 3>(3 * i + 2, 6 * i + 3) = triangle.axes.row(2);
    else
      for (int j = 0; j < 3; ++j)
        map.block<1, 3>(3 * i + 2, 6 * j) =
            triangle.side((j + 1) % 3, (j + 2) % 3).transpose() / (4.0 * triangle.area) * triangle.axes.topRows<2>();
  }
  return map;
}

/// [w b_x b_y] of the corners, b = theta x n = [theta_y, -theta_x].
Eigen::Matrix<double, 9, 18> to_flexure(const Eigen::Matrix3d& axes) {
  Eigen::Matrix<double, 9, 18> map = Eigen::Matrix<double, 9, 18>::Zero();
  for (int i = 0; i < 3; ++i) {
    map.block<1, 3>(3 * i, 6 * i) = axes.row(2);
    map.block<1, 3>(3 * i + 1, 6 * i + 3) = axes.row(1);
    map.block<1, 3>(3 * i + 2, 6 * i + 3) = -axes.row(0);
  }
  return map;
}

Eigen::MatrixXd transformed(const Matrix9& stiffness, const Eigen::Matrix<double, 9, 18>& map) {
  const Matrix18 global = map.transpose() * stiffness * map;
  return 0.5 * (global + global.transpose());
}

PlateMass mass_of(const Triangle& triangle, MassKind mass_kind) {
  return plate_mass(triangle.area / 12.0 * (Eigen::Matrix3d::Ones() + Eigen::Matrix3d::Identity()), mass_kind);
}

void carry_to_nodes(ElementMatrices& matrices, const Triangle& triangle, double offset) {
  if (offset == 0.0) return;
  const Eigen::Vector3d normal = triangle.axes.row(2);
  kalfem::carry_to_nodes(matrices, offset * normal.replicate<1, 3>());
}

}  // namespace

ElementMatrices shell3(const Eigen::Matrix3d& corners, double poissons_ratio, const ShellProperty& property,
                       MassKind mass_kind, const DrillingOptions& drilling) {
  const Triangle triangle = triangle_through(corners, Eigen::Vector3d::Zero(), drilling);
  const Matrix9 membrane = membrane_stiffness(triangle, plane_stress(poissons_ratio));
  const Matrix9 flexure = flexure_stiffness(triangle, isotropic_section(poissons_ratio, property.thickness));
  ElementMatrices matrices{
      .stiffness = {{{.youngs_modulus = 1, .thickness = 1}, transformed(membrane, to_membrane(triangle))},
                    {{.youngs_modulus = 1}, transformed(flexure, to_flexure(triangle.axes))}},
      .mass = isotropic_mass(mass_of(triangle, mass_kind), property.nonstructural_mass)};
  carry_to_nodes(matrices, triangle, property.offset);
  return matrices;
}

ElementMatrices shell3(const Eigen::Matrix3d& corners, const LaminateProperty& property,
                       const Eigen::Vector3d& direction, MassKind mass_kind, const DrillingOptions& drilling) {
  const Triangle triangle = triangle_through(corners, direction, drilling);
  const auto to_plane = to_membrane(triangle), to_bend = to_flexure(triangle.axes);
  const Matrix18 coupled = to_plane.transpose() * coupling_stiffness(triangle, property.stiffness.coupling) * to_bend;
  ElementMatrices matrices{
      .stiffness = {{{},
                     transformed(membrane_stiffness(triangle, property.stiffness.membrane), to_plane) +
                         transformed(flexure_stiffness(triangle, property.stiffness), to_bend) +
                         (coupled + coupled.transpose())}},
      .mass = section_mass(mass_of(triangle, mass_kind), property.mass, property.rotary_inertia)};
  carry_to_nodes(matrices, triangle, property.offset);
  return matrices;
}

// The membrane strain is the mean one and, linear over the triangle, 3/2 b_0^1/2 of the hierarchical rotations'.
ShellStrains shell3_strains(const Eigen::Matrix3d& corners, const ShellStiffness& section, double offset,
                            const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                            const DrillingOptions& drilling) {
  const Triangle triangle = triangle_through(corners, direction, drilling);
  const Eigen::Vector3d normal = triangle.axes.row(2);
  const Eigen::VectorXd u = moved_by_arms(motions, offset * normal.replicate<1, 3>());
  const Eigen::Matrix<double, 9, 1> in_plane = to_membrane(triangle) * u;
  const Flexure flexure(triangle);
  Eigen::Matrix<double, 11, 1> bent;
  bent.head<9>() = to_flexure(triangle.axes) * u;
  bent.tail<2>() = bubble_turns(full_flexure_stiffness(flexure, triangle.area, section)) * bent.head<9>();
  const Eigen::Vector3d mean = lumping(triangle).transpose() * in_plane / triangle.area;
  const double share = 1.5 * std::sqrt(linear_share(section.membrane));
  constexpr std::array<std::pair<double, double>, 3> middles = {{{0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}}};
  Eigen::Matrix<double, 8, 3> sampled;
  for (int side = 0; side < 3; ++side) {
    const auto [r, s] = middles[static_cast<std::size_t>(side)];
    sampled.col(side) << mean + share * linear_strains(triangle, side) * in_plane, flexure.curvatures(r, s) * bent,
        flexure.assumed_shear(r, s) * bent;
  }
  // A linear field has at a corner the sum of the middles of its two sides less that of the opposite one.
  const Eigen::Matrix3d to_corners{{1.0, 1.0, -1.0}, {-1.0, 1.0, 1.0}, {1.0, -1.0, 1.0}};
  return {triangle.axes, sampled * to_corners};
}

}  // namespace kalfem
