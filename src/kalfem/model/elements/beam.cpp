#include "kalfem/model/elements/beam.hpp"

#include <array>
#include <cmath>

namespace kalfem {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using PlaneRow = Eigen::RowVector4d;

/// Bending in one plane: its place among the twelve local degrees of freedom and its section.
struct Plane {
  std::array<int, 4> dofs;  ///< deflection and rotation of both ends
  double rotation_sign;     ///< -1 where the local rotation is minus the slope of the deflection
  double inertia;           ///< second moment [m^4]
  double phi;               ///< 12 E I / (G k A L^2)
  bool shear;               ///< Timoshenko
};

std::array<Plane, 2> planes_of(const BeamSection& section, double length, double poissons_ratio) {
  const auto phi = [&](double inertia, double factor) {
    return factor == 0.0 ? 0.0 : 24.0 * (1.0 + poissons_ratio) * inertia / (factor * section.area * length * length);
  };
  return {Plane{{1, 5, 7, 11},
                1.0,
                section.inertia_z,
                phi(section.inertia_z, section.shear_factor_y),
                section.shear_factor_y != 0.0},
          Plane{{2, 4, 8, 10},
                -1.0,
                section.inertia_y,
                phi(section.inertia_y, section.shear_factor_z),
                section.shear_factor_z != 0.0}};
}

void add_plane(Matrix12& matrix, const Plane& plane, Eigen::Matrix4d bending) {
  const Eigen::Vector4d signs(1.0, plane.rotation_sign, 1.0, plane.rotation_sign);
  bending = signs.asDiagonal() * bending * signs.asDiagonal();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) matrix(plane.dofs[i], plane.dofs[j]) += bending(i, j);
}

/// Adds value [a b; b a] to the degrees of freedom of one direction at both ends.
void add_pair(Matrix12& matrix, int direction, double own, double other) {
  matrix(direction, direction) += own;
  matrix(direction + 6, direction + 6) += own;
  matrix(direction, direction + 6) += other;
  matrix(direction + 6, direction) += other;
}

Eigen::Matrix4d bending_stiffness(const Plane& plane, double l) {
  const double phi = plane.phi;
  const Eigen::Matrix4d shape{{12.0, 6.0 * l, -12.0, 6.0 * l},
                              {6.0 * l, (4.0 + phi) * l * l, -6.0 * l, (2.0 - phi) * l * l},
                              {-12.0, -6.0 * l, 12.0, -6.0 * l},
                              {6.0 * l, (2.0 - phi) * l * l, -6.0 * l, (4.0 + phi) * l * l}};
  return plane.inertia / ((1.0 + phi) * l * l * l) * shape;
}

/// Deflection at s = x / L under end displacements without load between the ends [FK93].
PlaneRow deflection_shape(double s, double phi, double l) {
  const double s2 = s * s, s3 = s2 * s;
  return PlaneRow(2.0 * s3 - 3.0 * s2 - phi * s + 1.0 + phi, l * (s3 - (2.0 + phi / 2.0) * s2 + (1.0 + phi / 2.0) * s),
                  -2.0 * s3 + 3.0 * s2 + phi * s, l * (s3 - (1.0 - phi / 2.0) * s2 - phi / 2.0 * s)) /
         (1.0 + phi);
}

/// Rotation of the section that goes with it.
PlaneRow rotation_shape(double s, double phi, double l) {
  const double s2 = s * s;
  return PlaneRow(6.0 / l * (s2 - s), 3.0 * s2 - (4.0 + phi) * s + 1.0 + phi, -6.0 / l * (s2 - s),
                  3.0 * s2 - (2.0 - phi) * s) /
         (1.0 + phi);
}

/// Per unit density, by the Gauss rule of four points: exact for the products of cubics.
Eigen::Matrix4d bending_mass(const Plane& plane, double area, double l) {
  constexpr std::array<double, 4> places = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                            0.8611363115940526};
  constexpr std::array<double, 4> weights = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                             0.3478548451374538};
  Eigen::Matrix4d mass = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double s = 0.5 * (1.0 + places[i]), weight = 0.5 * l * weights[i];
    const PlaneRow deflection = deflection_shape(s, plane.phi, l), rotation = rotation_shape(s, plane.phi, l);
    mass += weight * area * deflection.transpose() * deflection;
    if (plane.shear) mass += weight * plane.inertia * rotation.transpose() * rotation;
  }
  return mass;
}

Matrix12 local_stiffness(const BeamSection& section, double length, double poissons_ratio) {
  Matrix12 stiffness = Matrix12::Zero();
  const double axial = section.area / length;
  const double torsion = section.torsion / (2.0 * (1.0 + poissons_ratio) * length);
  add_pair(stiffness, 0, axial, -axial);
  add_pair(stiffness, 3, torsion, -torsion);
  for (const auto& plane : planes_of(section, length, poissons_ratio))
    add_plane(stiffness, plane, bending_stiffness(plane, length));
  return stiffness;
}

Matrix12 consistent_mass(const BeamSection& section, double length, double poissons_ratio) {
  Matrix12 mass = Matrix12::Zero();
  const double total = section.area * length, polar = (section.inertia_y + section.inertia_z) * length;
  add_pair(mass, 0, total / 3.0, total / 6.0);
  add_pair(mass, 3, polar / 3.0, polar / 6.0);
  for (const auto& plane : planes_of(section, length, poissons_ratio))
    add_plane(mass, plane, bending_mass(plane, section.area, length));
  return mass;
}

Matrix12 lumped_mass(const BeamSection& section, double length, double poissons_ratio) {
  Matrix12 mass = Matrix12::Zero();
  const double total = section.area * length;
  for (const int direction : {0, 1, 2}) add_pair(mass, direction, total / 2.0, 0.0);
  add_pair(mass, 3, (section.inertia_y + section.inertia_z) * length / 2.0, 0.0);
  for (const auto& plane : planes_of(section, length, poissons_ratio))
    add_pair(mass, plane.dofs[1], total * length * length / 78.0 + (plane.shear ? plane.inertia * length / 2.0 : 0.0),
             0.0);
  return mass;
}

/// Rows: local x, y, z.
Eigen::Matrix3d local_axes(const Eigen::Vector3d& along, const Eigen::Vector3d& up) {
  const Eigen::Vector3d x = along.normalized();
  const Eigen::Vector3d across = up - up.dot(x) * x;
  // A smaller angle than 1e-6 rad would leave the local axes to rounding of the coordinates.
  if (!(across.norm() > 1e-6 * up.norm()))
    throw ElementShapeError("the direction 'up' of the section is parallel to the beam's axis or zero");
  const Eigen::Vector3d z = across.normalized();
  Eigen::Matrix3d axes;
  axes << x.transpose(), z.cross(x).transpose(), z.transpose();
  return axes;
}

/// Motion of the centroid's ends in local axes from that of the nodes in global ones.
Matrix12 node_to_centroid(const Eigen::Matrix3d& axes, const Eigen::Vector3d& offset) {
  Eigen::Matrix3d arm;  // omega x offset = arm omega
  arm << 0.0, offset.z(), -offset.y(), -offset.z(), 0.0, offset.x(), offset.y(), -offset.x(), 0.0;
  Matrix12 transform = Matrix12::Zero();
  for (const int node : {0, 6}) {
    transform.block<3, 3>(node, node) = axes;
    transform.block<3, 3>(node, node + 3) = axes * arm;
    transform.block<3, 3>(node + 3, node + 3) = axes;
  }
  return transform;
}

}  // namespace

ElementMatrices beam(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property, double poissons_ratio,
                     MassKind mass_kind) {
  const Eigen::Vector3d along = ends.col(1) - ends.col(0);
  const double length = along.norm();
  if (!(length > 1e-12 * ends.cwiseAbs().maxCoeff())) throw ElementShapeError("its ends coincide: the length is zero");
  const Matrix12 transform = node_to_centroid(local_axes(along, property.up), property.offset);
  const auto to_nodes = [&](const Matrix12& local) -> Eigen::MatrixXd {
    const Matrix12 global = transform.transpose() * local * transform;
    return 0.5 * (global + global.transpose());
  };
  const Matrix12 mass = mass_kind == MassKind::consistent ? consistent_mass(property.section, length, poissons_ratio)
                                                          : lumped_mass(property.section, length, poissons_ratio);
  return {.stiffness = {{{.youngs_modulus = 1}, to_nodes(local_stiffness(property.section, length, poissons_ratio))}},
          .mass = {{{.density = 1}, to_nodes(mass)}}};
}

}  // namespace kalfem
