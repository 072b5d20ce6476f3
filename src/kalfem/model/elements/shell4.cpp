// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "kalfem/model/elements/shell_strains.hpp"

namespace kalfem {
namespace {

using Corners = Eigen::Matrix<double, 3, 4>;
using Axes = Eigen::Matrix<double, 3, 2>;        ///< two vectors in a plane of the surface
using Row = Eigen::Matrix<double, 1, 24>;        ///< one strain per nodal displacement and rotation
using PlaneRows = Eigen::Matrix<double, 3, 24>;  ///< strains rr, ss, 2 rs, or 11, 22, 2 12
using ShearRows = Eigen::Matrix<double, 2, 24>;  ///< strains 2 rt, 2 st, or 2 13, 2 23
using Matrix24 = Eigen::Matrix<double, 24, 24>;

// Natural coordinates of the corners.
const Eigen::Vector4d corner_r(-1.0, 1.0, 1.0, -1.0);
const Eigen::Vector4d corner_s(-1.0, -1.0, 1.0, 1.0);

/// Part of G t that holds the drilling rotation to the turn of the surface, in the mean: softer, and strips that twist
/// get too soft; harder, and facets of distorted meshes get too stiff.
constexpr double drilling_share = 0.1;
/// Part of the bending stiffness that the gradient of the drilling rotation meets. It holds the patterns without mean,
/// whose vibration it keeps above that of waves in the plane of less than eight elements; it adds 1/50 (t/b)^2 to the
/// stiffness of a strip of width b bent in its plane.
constexpr double drilling_gradient_share = 0.02;

/// The bilinear mid-surface with its normals at the corners.
struct Surface {
  Corners corners;
  Corners normals;
};

/// The mid-surface x = sum N_i x_i and the directors d = sum N_i n_i at one place.
struct SurfacePoint {
  Eigen::Vector4d shape;               ///< N_i
  Eigen::Matrix<double, 4, 2> slopes;  ///< N_i,r and N_i,s
  Axes tangents;                       ///< x,r and x,s
  Eigen::Vector3d director;            ///< d
  Axes director_slopes;                ///< d,r and d,s

  [[nodiscard]] Eigen::Vector3d area_vector() const {
    return Eigen::Vector3d(tangents.col(0)).cross(Eigen::Vector3d(tangents.col(1)));
  }
  /// g^r and g^s: in the tangent plane, g^a . x,b = 1 for a = b, else 0.
  [[nodiscard]] Axes dual() const { return tangents * (tangents.transpose() * tangents).inverse(); }
};

SurfacePoint point_at(const Surface& surface, double r, double s) {
  SurfacePoint point;
  const Eigen::Array4d along_r = 1.0 + r * corner_r.array(), along_s = 1.0 + s * corner_s.array();
  point.shape = 0.25 * along_r * along_s;
  point.slopes.col(0) = 0.25 * corner_r.array() * along_s;
  point.slopes.col(1) = 0.25 * corner_s.array() * along_r;
  point.tangents = surface.corners * point.slopes;
  point.director = surface.normals * point.shape;
  point.director_slopes = surface.normals * point.slopes;
  return point;
}

/// Throws ElementShapeError for a shape on which the surface has no normal or turns over.
Surface surface_through(const Corners& corners) {
  require_distinct(corners);
  Surface surface{corners, Corners::Zero()};
  const Eigen::Vector3d centre = point_at(surface, 0.0, 0.0).area_vector();
  const double extent = (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).norm();
  if (!(centre.norm() > 1e-10 * extent * extent)) throw ElementShapeError("its area is zero");
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d area = point_at(surface, corner_r[i], corner_s[i]).area_vector();
    if (!(area.dot(centre) > 1e-8 * centre.squaredNorm()))
      throw ElementShapeError("it is concave, crossed or degenerate: at corner " + std::to_string(i + 1) +
                              " the Jacobian is not positive");
    surface.normals.col(i) = area.normalized();
  }
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j)
      if (!(surface.normals.col(i).dot(surface.normals.col(j)) > 0.0))
        throw ElementShapeError("it is warped by more than a right angle between its corners " + std::to_string(j + 1) +
                                " and " + std::to_string(i + 1));
  return surface;
}

auto displacement(auto& rows, int node) { return rows.template middleCols<3>(6 * node); }
auto rotation(auto& rows, int node) { return rows.template middleCols<3>(6 * node + 3); }

/// e_ab = (x,a . u,b + x,b . u,a) / 2 of the interpolated displacements.
PlaneRows membrane_strains(const SurfacePoint& point) {
  const Eigen::RowVector3d g_r = point.tangents.col(0), g_s = point.tangents.col(1);
  PlaneRows strains = PlaneRows::Zero();
  for (int i = 0; i < 4; ++i) {
    const double n_r = point.slopes(i, 0), n_s = point.slopes(i, 1);
    displacement(strains, i) << n_r * g_r, n_s * g_s, n_s * g_r + n_r * g_s;
  }
  return strains;
}

/// The part of the strain that grows with the distance from the mid-surface,
///     k_ab = (x,a . v,b + x,b . v,a + d,a . u,b + d,b . u,a) / 2,   v = sum N_i theta_i x n_i.
PlaneRows bending_strains(const Surface& surface, const SurfacePoint& point) {
  const Eigen::Vector3d g_r = point.tangents.col(0), g_s = point.tangents.col(1);
  const Eigen::RowVector3d d_r = point.director_slopes.col(0), d_s = point.director_slopes.col(1);
  PlaneRows strains = PlaneRows::Zero();
  for (int i = 0; i < 4; ++i) {
    const double n_r = point.slopes(i, 0), n_s = point.slopes(i, 1);
    const Eigen::Vector3d normal = surface.normals.col(i);
    const Eigen::RowVector3d across_r = normal.cross(g_r), across_s = normal.cross(g_s);
    displacement(strains, i) << n_r * d_r, n_s * d_s, n_s * d_r + n_r * d_s;
    rotation(strains, i) << n_r * across_r, n_s * across_s, n_s * across_r + n_r * across_s;
  }
  return strains;
}

/// 2 e_at = x,a . v + d . u,a of the interpolated motion.
ShearRows transverse_strains(const Surface& surface, const SurfacePoint& point) {
  ShearRows strains = ShearRows::Zero();
  for (int i = 0; i < 4; ++i)
    for (int a = 0; a < 2; ++a) {
      const Eigen::Vector3d normal = surface.normals.col(i), tangent = point.tangents.col(a);
      displacement(strains, i).row(a) = point.slopes(i, a) * point.director.transpose();
      rotation(strains, i).row(a) = point.shape[i] * normal.cross(tangent).transpose();
    }
  return strains;
}

/// Transverse shear linear between the middles of opposite sides [DB84].
class AssumedTransverseShear {
public:
  explicit AssumedTransverseShear(const Surface& surface) {
    const auto row = [&](double r, double s, int a) -> Row {
      return transverse_strains(surface, point_at(surface, r, s)).row(a);
    };
    top_ = row(0.0, 1.0, 0), bottom_ = row(0.0, -1.0, 0), right_ = row(1.0, 0.0, 1), left_ = row(-1.0, 0.0, 1);
  }
  [[nodiscard]] ShearRows at(double r, double s) const {
    ShearRows strains;
    strains << 0.5 * ((1.0 + s) * top_ + (1.0 - s) * bottom_), 0.5 * ((1.0 + r) * right_ + (1.0 - r) * left_);
    return strains;
  }

private:
  Row top_, bottom_, right_, left_;
};

/// Membrane strains from those along the four sides and the shear at the centre [KLB17]. With x,r = x_r + s x_d and
/// u,r = u_r + s u_d, the interpolated ones hold x_d . u_d, which on a warped surface answers bending with membrane
/// strain. It is replaced by the sum of side strains that equals it on a flat one.
class AssumedMembrane {
public:
  explicit AssumedMembrane(const Surface& surface) {
    const auto row = [&](double r, double s, int a) -> Row { return membrane_strains(point_at(surface, r, s)).row(a); };
    const Row a = row(0.0, 1.0, 0), b = row(0.0, -1.0, 0), c = row(1.0, 0.0, 1), d = row(-1.0, 0.0, 1);
    mean_rr_ = 0.5 * (a + b), slope_rr_ = 0.5 * (a - b);
    mean_ss_ = 0.5 * (c + d), slope_ss_ = 0.5 * (c - d);
    centre_ = row(0.0, 0.0, 2);
    const Eigen::Vector3d hourglass = 0.25 * surface.corners * corner_r.cwiseProduct(corner_s);
    const Eigen::Vector2d skew = point_at(surface, 0.0, 0.0).dual().transpose() * hourglass;
    const double c_r = skew[0], c_s = skew[1];
    hourglass_ = (c_r * (c_r * mean_rr_ - slope_rr_) + c_s * (c_s * mean_ss_ - slope_ss_) + c_r * c_s * centre_) /
                 (skew.squaredNorm() - 1.0);
  }
  [[nodiscard]] PlaneRows at(double r, double s) const {
    PlaneRows strains;
    strains << mean_rr_ + s * slope_rr_ + (s * s - 1.0) * hourglass_,
        mean_ss_ + r * slope_ss_ + (r * r - 1.0) * hourglass_,
        centre_ + r * slope_rr_ + s * slope_ss_ + 2.0 * r * s * hourglass_;
    return strains;
  }

private:
  Row mean_rr_, slope_rr_, mean_ss_, slope_ss_, centre_, hourglass_;
};

/// From strains [rr, ss, 2 rs] to [11, 22, 2 12] in axes e_1, e_2; `turn` has the entries e_a . g^b.
Eigen::Matrix3d to_axes(const Eigen::Matrix2d& turn) {
  const double a = turn(0, 0), b = turn(0, 1), c = turn(1, 0), d = turn(1, 1);
  return Eigen::Matrix3d{{a * a, b * b, a * b}, {c * c, d * d, c * d}, {2.0 * a * c, 2.0 * b * d, a * d + b * c}};
}

/// Sums over the Gauss points.
struct Sums {
  Matrix24 stretching = Matrix24::Zero();  ///< of A, B and S
  Matrix24 bending = Matrix24::Zero();     ///< of D
  Matrix24 drilling_gradient = Matrix24::Zero();
  Eigen::Matrix4d shares = Eigen::Matrix4d::Zero();  ///< int N_i N_j dA
};

/// The rotation that carries a unit vector into another, not the opposite one, about the normal of both:
///     R = I + [w] + [w]^2 / (1 + from . to),   w = from x to.
Eigen::Matrix3d shortest_turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d w = from.cross(to);
  const Eigen::Matrix3d cross{{0.0, -w.z(), w.y()}, {w.z(), 0.0, -w.x()}, {-w.y(), w.x(), 0.0}};
  return Eigen::Matrix3d::Identity() + cross + cross * cross / (1.0 + from.dot(to));
}

/// Orthonormal axes in the tangent plane of the centre; those of another place are turned the shortest way from these.
struct Frame {
  Eigen::Vector3d normal;
  Axes axes;

  [[nodiscard]] Axes at(const Eigen::Vector3d& other_normal) const {
    return shortest_turn(normal, other_normal) * axes;
  }
};

/// With the first axis along `direction`, or along the first side where that is zero.
Frame frame_of(const Surface& surface, const Eigen::Vector3d& direction) {
  Frame frame;
  frame.normal = point_at(surface, 0.0, 0.0).area_vector().normalized();
  frame.axes.col(0) = axis_in_surface(direction, surface.corners.col(1) - surface.corners.col(0), frame.normal);
  frame.axes.col(1) = frame.normal.cross(Eigen::Vector3d(frame.axes.col(0)));
  return frame;
}

/// int e^T A e + 2 e^T B k dA with four membrane strain modes of the element's own, linear in r and s and without mean,
/// condensed [SR90]: they let the sides curve, so that bending in the plane meets no shear and no strain across.
class EnhancedMembrane {
public:
  explicit EnhancedMembrane(const ShellStiffness& section) : section_(section) {}

  void add(const PlaneRows& stretched, const PlaneRows& bent, const Eigen::Matrix<double, 3, 4>& modes, double area) {
    const PlaneRows coupled = section_.coupling * bent;
    const PlaneRows stresses = section_.membrane * stretched + coupled;
    nodal_ += area * (stretched.transpose() * stresses + coupled.transpose() * stretched);
    mixed_ += area * modes.transpose() * stresses;
    modal_ += area * modes.transpose() * section_.membrane * modes;
  }
  [[nodiscard]] Matrix24 condensed() const { return nodal_ + mixed_.transpose() * amounts(); }
  /// Of each mode per motion of the corners.
  [[nodiscard]] Eigen::Matrix<double, 4, 24> amounts() const { return -modal_.llt().solve(mixed_); }

private:
  const ShellStiffness& section_;
  Matrix24 nodal_ = Matrix24::Zero();
  Eigen::Matrix<double, 4, 24> mixed_ = Eigen::Matrix<double, 4, 24>::Zero();
  Eigen::Matrix4d modal_ = Eigen::Matrix4d::Zero();
};

/// Modes r of rr, s of ss, r and s of rs.
Eigen::Matrix<double, 3, 4> enhanced_modes(double r, double s) {
  return Eigen::Matrix<double, 3, 4>{{r, 0.0, 0.0, 0.0}, {0.0, s, 0.0, 0.0}, {0.0, 0.0, r, s}};
}

/// Replaces the rotations about the normal of the corners that follow by the turn of the surface, in rows that hold
/// rotations about the normal.
template <typename Rows>
void follow(Rows& rows, const Row& turn, const Eigen::Vector3d& normal, const DrillingOptions& drilling) {
  for (int i = 0; i < 4; ++i) {
    if (!drilling.following[static_cast<std::size_t>(i)]) continue;
    rows += (rotation(rows, i) * normal).eval() * turn;
    rotation(rows, i).setZero();
  }
}

/// The turn of the surface about the normal at the centre, n . sum_a g^a x u,a / 2.
Row surface_turn(const SurfacePoint& centre, const Eigen::Vector3d& normal) {
  const Axes dual = centre.dual();
  Row turn = Row::Zero();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d slope = dual * centre.slopes.row(i).transpose();  // n . (slope x u) = u . (n x slope)
    displacement(turn, i) = 0.5 * normal.cross(slope).transpose();
  }
  return turn;
}

/// Gradient in the axes of the rotation about the centre's normal.
ShearRows drilling_gradient(const SurfacePoint& point, const Eigen::Matrix2d& turn, const Eigen::Vector3d& normal) {
  const Eigen::Matrix<double, 2, 4> gradient = turn * point.slopes.transpose();
  ShearRows rows = ShearRows::Zero();
  for (int i = 0; i < 4; ++i) rotation(rows, i) = gradient.col(i) * normal.transpose();
  return rows;
}

/// theta . n at the centre beyond the turn of the surface [HB89].
Row drilling_strain(const SurfacePoint& centre, const Eigen::Vector3d& normal, const DrillingOptions& drilling) {
  const Row turn = surface_turn(centre, normal);
  Row strain = -turn;
  for (int i = 0; i < 4; ++i) rotation(strain, i) = centre.shape[i] * normal.transpose();
  follow(strain, turn, normal, drilling);
  return strain;
}

/// Strains in the axes of the section at one Gauss point.
struct GaussPoint {
  Eigen::Vector4d shape;  ///< N_i
  double area = 0.0;      ///< that the point stands for
  PlaneRows stretched, bent;
  ShearRows sheared, drilled;
  Eigen::Matrix<double, 3, 4> modes;  ///< enhanced membrane strains
};

std::array<GaussPoint, 4> gauss_points(const Surface& surface, const Frame& frame, const DrillingOptions& drilling) {
  const AssumedMembrane membrane(surface);
  const AssumedTransverseShear transverse(surface);
  const SurfacePoint centre = point_at(surface, 0.0, 0.0);
  const Row surface_turns = surface_turn(centre, frame.normal);
  const Eigen::Matrix3d centre_to_axes = to_axes(frame.axes.transpose() * centre.dual());
  std::array<GaussPoint, 4> points;
  const double gauss = 1.0 / std::sqrt(3.0);
  for (int i = 0; i < 4; ++i) {
    const double r = gauss * corner_r[i], s = gauss * corner_s[i];
    const SurfacePoint point = point_at(surface, r, s);
    const double area = point.area_vector().norm();
    const Eigen::Vector3d normal = point.area_vector() / area;
    const Eigen::Matrix2d turn = frame.at(normal).transpose() * point.dual();
    const Eigen::Matrix3d tensor_turn = to_axes(turn);
    ShearRows drilled = drilling_gradient(point, turn, frame.normal);
    follow(drilled, surface_turns, frame.normal, drilling);
    const double density = centre.area_vector().norm() / area;
    points[static_cast<std::size_t>(i)] = {.shape = point.shape,
                                           .area = area,
                                           .stretched = tensor_turn * membrane.at(r, s),
                                           .bent = tensor_turn * bending_strains(surface, point),
                                           .sheared = turn * transverse.at(r, s) / point.director.dot(normal),
                                           .drilled = drilled,
                                           .modes = density * centre_to_axes * enhanced_modes(r, s)};
  }
  return points;
}

EnhancedMembrane enhanced_membrane(const std::array<GaussPoint, 4>& points, const ShellStiffness& section) {
  EnhancedMembrane enhanced(section);
  for (const auto& point : points) enhanced.add(point.stretched, point.bent, point.modes, point.area);
  return enhanced;
}

Sums integrate(const Surface& surface, const Frame& frame, const ShellStiffness& section,
               const DrillingOptions& drilling) {
  const auto points = gauss_points(surface, frame, drilling);
  Sums sums;
  for (const auto& point : points) {
    sums.bending += point.area * point.bent.transpose() * section.bending * point.bent;
    sums.stretching += point.area * point.sheared.transpose() * section.shear * point.sheared;
    sums.drilling_gradient += point.area * point.drilled.transpose() * point.drilled;
    sums.shares += point.area * point.shape * point.shape.transpose();
  }
  sums.stretching += enhanced_membrane(points, section).condensed();
  return sums;
}

/// G of an isotropic stiffness, in the mean over all directions of any: 2 / (a_11 + a_22 - 2 a_12 + a_66), a = A^-1.
double mean_shear(const Eigen::Matrix3d& membrane) {
  const Eigen::Matrix3d a = membrane.inverse();
  return 2.0 / (a(0, 0) + a(1, 1) - 2.0 * a(0, 1) + a(2, 2));
}

/// E of an isotropic stiffness, likewise: 8 / (3 d_11 + 3 d_22 + 2 d_12 + d_66), d = D^-1.
double mean_rigidity(const Eigen::Matrix3d& bending) {
  const Eigen::Matrix3d d = bending.inverse();
  return 8.0 / (3.0 * d(0, 0) + 3.0 * d(1, 1) + 2.0 * d(0, 1) + d(2, 2));
}

/// Stiffness in two parts, of which the second is that of D.
struct Stiffness {
  Eigen::MatrixXd stretching, bending;
  Eigen::Matrix4d shares;
};

Stiffness stiffness_of(const Surface& surface, const Eigen::Vector3d& direction, const ShellStiffness& section,
                       const DrillingOptions& options) {
  const Frame frame = frame_of(surface, direction);
  const Sums sums = integrate(surface, frame, section, options);
  const Row drilling = drilling_strain(point_at(surface, 0.0, 0.0), frame.normal, options);
  const Matrix24 stretching = sums.stretching + drilling_share * mean_shear(section.membrane) * sums.shares.sum() *
                                                    drilling.transpose() * drilling;
  const Matrix24 bending =
      sums.bending + drilling_gradient_share * mean_rigidity(section.bending) * sums.drilling_gradient;
  return {0.5 * (stretching + stretching.transpose()), 0.5 * (bending + bending.transpose()), sums.shares};
}

/// The mid-surface off the nodes, with the arms from these to its corners.
struct OffsetSurface {
  Eigen::Matrix3Xd arms;
  Surface surface;

  OffsetSurface(const Corners& corners, double offset) {
    surface = surface_through(corners);
    arms = offset * surface.normals;
    if (offset != 0.0) surface = surface_through(corners + arms);
  }
};

}  // namespace

ElementMatrices shell4(const Corners& corners, double poissons_ratio, const ShellProperty& property, MassKind mass_kind,
                       const DrillingOptions& drilling) {
  const OffsetSurface offset(corners, property.offset);
  auto stiffness =
      stiffness_of(offset.surface, Eigen::Vector3d::Zero(), isotropic_section(poissons_ratio, 1.0), drilling);
  ElementMatrices matrices{
      .stiffness = {{{.youngs_modulus = 1, .thickness = 1}, std::move(stiffness.stretching)},
                    {{.youngs_modulus = 1, .thickness = 3}, std::move(stiffness.bending)}},
      .mass = isotropic_mass(plate_mass(stiffness.shares, mass_kind), property.nonstructural_mass)};
  if (property.offset != 0.0) carry_to_nodes(matrices, offset.arms);
  return matrices;
}

ElementMatrices shell4(const Corners& corners, const LaminateProperty& property, const Eigen::Vector3d& direction,
                       MassKind mass_kind, const DrillingOptions& drilling) {
  const OffsetSurface offset(corners, property.offset);
  const auto stiffness = stiffness_of(offset.surface, direction, property.stiffness, drilling);
  ElementMatrices matrices{
      .stiffness = {{{}, stiffness.stretching + stiffness.bending}},
      .mass = section_mass(plate_mass(stiffness.shares, mass_kind), property.mass, property.rotary_inertia)};
  if (property.offset != 0.0) carry_to_nodes(matrices, offset.arms);
  return matrices;
}

ShellStrains shell4_strains(const Corners& corners, const ShellStiffness& section, double offset,
                            const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                            const DrillingOptions& drilling) {
  const OffsetSurface moved(corners, offset);
  const Frame frame = frame_of(moved.surface, direction);
  const Eigen::Matrix<double, 24, 1> u = moved_by_arms(motions, moved.arms);
  const auto points = gauss_points(moved.surface, frame, drilling);
  const Eigen::Vector4d amounts = enhanced_membrane(points, section).amounts() * u;
  Eigen::Matrix<double, 8, 4> sampled;
  Eigen::Matrix4d shapes;  // of the corners at the points
  for (int i = 0; i < 4; ++i) {
    const auto& point = points[static_cast<std::size_t>(i)];
    sampled.col(i) << point.stretched * u + point.modes * amounts, point.bent * u, point.sheared * u;
    shapes.col(i) = point.shape;
  }
  ShellStrains strains{{}, sampled * shapes.inverse()};
  strains.axes << frame.axes.transpose(), frame.normal.transpose();
  return strains;
}

}  // namespace kalfem
