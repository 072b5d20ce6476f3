// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/beam_forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "kalfem/model/elements/tapered_beam.hpp"

namespace kalfem {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Pair = Eigen::Matrix<double, 2, 12>;  ///< [v, w], or the slopes [theta_z, -theta_y], from the motions of the ends

/// Adds value [a b; b a] to the degrees of freedom of one direction at both ends.
void add_pair(Matrix12& matrix, int direction, double own, double other) {
  matrix(direction, direction) += own;
  matrix(direction + 6, direction + 6) += own;
  matrix(direction, direction + 6) += other;
  matrix(direction + 6, direction) += other;
}

Pair deflections_of_end(int first) {
  Pair rows = Pair::Zero();
  rows(0, first + 1) = rows(1, first + 2) = 1.0;
  return rows;
}

Pair slopes_of_end(int first) {
  Pair rows = Pair::Zero();
  rows(0, first + 5) = 1.0;
  rows(1, first + 4) = -1.0;
  return rows;
}

/// Bending of both planes without load between the ends, per unit E. With P = (1 + 12 S D / L^2)^-1 the curvature's
/// change along the element is -12/L^3 P times the lateral offset of the ends.
class Bending {
public:
  Bending(const BeamSection& section, double length, double poissons_ratio) : length_(length) {
    rigidity_ << section.inertia_z, section.product_yz, section.product_yz, section.inertia_y;
    const auto flexibility = [&](double factor) {
      return factor == 0.0 ? 0.0 : 2.0 * (1.0 + poissons_ratio) / (factor * section.area);
    };
    const Eigen::Vector2d shear(flexibility(section.shear_factor_y), flexibility(section.shear_factor_z));
    share_ = (Eigen::Matrix2d::Identity() + 12.0 / (length * length) * shear.asDiagonal() * rigidity_).inverse();
  }

  [[nodiscard]] Matrix12 stiffness() const {
    const double l = length_;
    const Eigen::Matrix2d bent = rigidity_ / l, sheared = 12.0 / (l * l * l) * rigidity_ * share_;
    const Pair change = slopes_of_end(6) - slopes_of_end(0);
    const Pair bow = sway();
    return change.transpose() * bent * change + bow.transpose() * sheared * bow;
  }
  /// At s = x / L [FK93].
  [[nodiscard]] Pair deflections(double s) const {
    const double cubic = s * (s - 1.0) * (s - 0.5), bow = 0.5 * s * (1.0 - s);
    return (1.0 - s) * deflections_of_end(0) + s * deflections_of_end(6) +
           length_ * bow * (slopes_of_end(0) - slopes_of_end(6)) + 2.0 * cubic * share_ * sway();
  }
  [[nodiscard]] Pair slopes(double s) const {
    return (1.0 - s) * slopes_of_end(0) + s * slopes_of_end(6) + 6.0 / length_ * s * (s - 1.0) * share_ * sway();
  }

  /// Slopes of the deflections, which differ from the turns of the section by the shear strain.
  [[nodiscard]] Pair deflection_slopes(double s) const {
    return (deflections_of_end(6) - deflections_of_end(0)) / length_ +
           0.5 * (1.0 - 2.0 * s) * (slopes_of_end(0) - slopes_of_end(6)) +
           2.0 / length_ * (3.0 * s * (s - 1.0) + 0.5) * share_ * sway();
  }

private:
  /// Ends out of line with their mean slope.
  [[nodiscard]] Pair sway() const {
    return deflections_of_end(0) - deflections_of_end(6) + 0.5 * length_ * (slopes_of_end(0) + slopes_of_end(6));
  }

  double length_;
  Eigen::Matrix2d rigidity_;
  Eigen::Matrix2d share_;  ///< P
};

/// From the motions of the line's ends to those with u at the centroid.
Matrix12 axial_at_centroid(const Eigen::Vector2d& centroid) {
  Matrix12 transform = Matrix12::Identity();
  for (const int end : {0, 6}) {
    transform(end, end + 4) = centroid.y();
    transform(end, end + 5) = -centroid.x();
  }
  return transform;
}

/// Of the motions of one plane alone, where the planes are not coupled.
Matrix12 in_plane(const Matrix12& bending, int deflection, int slope) {
  const std::array<int, 4> motions = {deflection, slope, deflection + 6, slope + 6};
  Matrix12 plane = Matrix12::Zero();
  plane(motions, motions) = bending(motions, motions);
  return plane;
}

/// One part of the stiffness per unit E, in the motions of the line's ends with u at the centroid.
Matrix12 centroid_stiffness(BeamPart part, const BeamSection& section, const Bending& bending, double length,
                            double poissons_ratio) {
  Matrix12 stiffness = Matrix12::Zero();
  const bool whole = part == BeamPart::none || part == BeamPart::stiffness;
  if (whole || part == BeamPart::bending) stiffness = bending.stiffness();
  if (part == BeamPart::bending_y) stiffness = in_plane(bending.stiffness(), 2, 4);
  if (part == BeamPart::bending_z) stiffness = in_plane(bending.stiffness(), 1, 5);
  const double axial = section.area / length;
  const double torsion = section.torsion / (2.0 * (1.0 + poissons_ratio) * length);
  if (whole || part == BeamPart::axial) add_pair(stiffness, 0, axial, -axial);
  if (whole || part == BeamPart::torsion) add_pair(stiffness, 3, torsion, -torsion);
  return stiffness;
}

/// The same in the motions of the line's ends.
Matrix12 local_stiffness(BeamPart part, const BeamSection& section, const Bending& bending, double length,
                         double poissons_ratio) {
  const Matrix12 transform = axial_at_centroid(section.centroid);
  return transform.transpose() * centroid_stiffness(part, section, bending, length, poissons_ratio) * transform;
}

// Gauss's rule of four points on [-1, 1]: exact for the products of cubics.
constexpr std::array<double, 4> places = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                          0.8611363115940526};
constexpr std::array<double, 4> weights = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                           0.3478548451374538};

/// Motions of the line at the share s of the length.
SectionMotions section_motions(const BeamSection& section, const Bending& bending, double s) {
  const Pair slopes = bending.slopes(s);
  SectionMotions motions = SectionMotions::Zero();
  motions(0, 0) = motions(3, 3) = 1.0 - s, motions(0, 6) = motions(3, 9) = s;
  motions.row(0) += section.centroid.transpose() * slopes;
  motions.middleRows<2>(1) = bending.deflections(s);
  motions.row(4) = -slopes.row(1);
  motions.row(5) = slopes.row(0);
  return motions * axial_at_centroid(section.centroid);
}

/// What stands at either end of a lumped line.
LineMass half_of(LineMass mass, double length) {
  mass.amount *= 0.5 * length;
  mass.polar *= 0.5 * length;
  mass.rotary *= 0.5 * length;
  return mass;
}

/// To 1e-9 of its diagonal.
bool is_positive_definite(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  return scaled.allFinite() &&
         Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0] > 1e-9;
}

/// Motions of the ends that leave the released ones without force, from all twelve.
Matrix12 without_released(const Matrix12& stiffness, const std::array<bool, 12>& released, double length) {
  std::vector<int> free, kept;
  for (int i = 0; i < 12; ++i) (released[static_cast<std::size_t>(i)] ? free : kept).push_back(i);
  Matrix12 transform = Matrix12::Identity();
  if (free.empty()) return transform;
  Eigen::VectorXd scale(static_cast<Eigen::Index>(free.size()));  // rotations times the length: entries of one unit
  for (std::size_t i = 0; i < free.size(); ++i)
    scale[static_cast<Eigen::Index>(i)] = free[i] % 6 < 3 ? 1.0 : 1.0 / length;
  const Eigen::MatrixXd own = scale.asDiagonal() * stiffness(free, free) * scale.asDiagonal();
  const Eigen::MatrixXd pull = scale.asDiagonal() * stiffness(free, kept);
  if (!is_positive_definite(own))
    throw ElementShapeError("its released motions make it a mechanism: too many hinges, or hinges without stiffness");
  transform(free, Eigen::all).setZero();
  transform(free, kept) = -(scale.asDiagonal() * own.ldlt().solve(pull));
  return transform;
}

/// Whether a beam is the same in all directions across its axis, as circles and circular tubes are.
bool is_round(const BeamProperty& property, const BeamPlacement& placement) {
  const BeamSection& section = property.section;
  return section.outline.corners.empty() && section.inertia_y == section.inertia_z && section.product_yz == 0.0 &&
         section.shear_factor_y == section.shear_factor_z && section.centroid.isZero(0.0) &&
         property.nonstructural_centre.isZero(0.0) &&
         std::ranges::find(placement.released, true) == placement.released.end();
}

/// The global axis farthest from a direction.
Eigen::Vector3d axis_across(const Eigen::Vector3d& along) {
  Eigen::Index farthest = 0;
  along.cwiseAbs().minCoeff(&farthest);
  return Eigen::Vector3d::Unit(farthest);
}

/// `vector` without its part along the unit vector x.
Eigen::Vector3d normal_part(const Eigen::Vector3d& vector, const Eigen::Vector3d& x) {
  return vector - vector.dot(x) * x;
}

/// Rows: local x, y, z. Where `up` gives no direction, any will do for a round beam.
Eigen::Matrix3d local_axes(const Eigen::Vector3d& along, const Eigen::Vector3d& up, bool round) {
  const Eigen::Vector3d x = along.normalized();
  Eigen::Vector3d across = normal_part(up, x);
  // A smaller angle than 1e-6 rad would leave the local axes to rounding of the coordinates.
  if (!(across.norm() > 1e-6 * up.norm())) {
    if (!round) throw ElementShapeError("its axis is parallel to 'up', which turns the section ([0, 0, 1] by default)");
    across = normal_part(axis_across(x), x);
  }
  const Eigen::Vector3d z = across.normalized();
  Eigen::Matrix3d axes;
  axes << x.transpose(), z.cross(x).transpose(), z.transpose();
  return axes;
}

/// Motion of the line's ends in local axes from that of the nodes in global ones.
Matrix12 node_to_line(const Eigen::Matrix3d& axes, const Eigen::Matrix<double, 3, 2>& offsets) {
  Matrix12 transform = Matrix12::Zero();
  for (const int end : {0, 1}) {
    const Eigen::Vector3d offset = offsets.col(end);
    Eigen::Matrix3d arm;  // omega x offset = arm omega
    arm << 0.0, offset.z(), -offset.y(), -offset.z(), 0.0, offset.x(), offset.y(), -offset.x(), 0.0;
    const int first = 6 * end;
    transform.block<3, 3>(first, first) = axes;
    transform.block<3, 3>(first, first + 3) = axes * arm;
    transform.block<3, 3>(first + 3, first + 3) = axes;
  }
  return transform;
}

/// A beam between its line's ends, with what carries it to the nodes.
struct PlacedBeam {
  double length = 0.0;
  Eigen::Matrix3d axes;   ///< rows: local x, y, z
  Matrix12 to_line;       ///< motions of the line's ends in local axes from those of the nodes in global ones
  Matrix12 not_released;  ///< of the line's ends that leave released motions without force, from these
  std::optional<TaperedLine> tapered;

  PlacedBeam(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property, const BeamPlacement& placement,
             double poissons_ratio) {
    const BeamSection& section = property.section;
    const Eigen::Matrix<double, 3, 2> line = ends + placement.offsets;
    const Eigen::Vector3d along = line.col(1) - line.col(0);
    length = along.norm();
    if (!(length > 1e-12 * line.cwiseAbs().maxCoeff()))
      throw ElementShapeError("its ends coincide: the length is zero");
    axes = local_axes(along, placement.up, is_round(property, placement));
    to_line = node_to_line(axes, placement.offsets);
    if (!property.stations.empty()) tapered.emplace(property.stations, length, poissons_ratio, property.lumped_inertia);
    const Bending bending(section, length, poissons_ratio);
    const Matrix12 stiffness =
        tapered ? tapered->stiffness() : local_stiffness(BeamPart::none, section, bending, length, poissons_ratio);
    not_released = without_released(stiffness, placement.released, length);
  }
};

/// Calls `visit` with the shares of Gauss's points and their weights, which sum to the length.
void at_gauss_points(double length, const auto& visit) {
  for (std::size_t i = 0; i < places.size(); ++i) visit(0.5 * (1.0 + places[i]), 0.5 * length * weights[i]);
}

Matrix12 line_mass(const LineMass& mass, const BeamProperty& property, const Bending& bending, double length,
                   MassKind mass_kind) {
  Matrix12 sum = Matrix12::Zero();
  if (mass_kind == MassKind::consistent)
    at_gauss_points(length, [&](double s, double weight) {
      sum += weight * mass_at_section(mass, section_motions(property.section, bending, s));
    });
  else
    for (const int end : {0, 1}) sum += mass_at_end(half_of(mass, length), end, length, property.lumped_inertia);
  return sum;
}

LineMass nonstructural_mass(const BeamProperty& property) {
  return {.amount = property.nonstructural_mass, .place = property.nonstructural_centre};
}
bool has_nonstructural_mass(const BeamProperty& property) {
  return property.nonstructural_mass != 0.0 || std::ranges::any_of(property.stations, [](const BeamStation& station) {
           return station.nonstructural_mass != 0.0 || station.nonstructural_inertia != 0.0;
         });
}

/// The field along the line, in its axes.
LineField line_field(const BeamField& field, const PlacedBeam& placed, const BeamPlacement& placement) {
  return {placed.axes * (field.at_nodes + field.gradient * placement.offsets),
          placed.axes * field.gradient * placed.axes.transpose()};
}

/// Forces of a field at the line's ends, local axes.
Vector12 field_forces(const PlacedBeam& placed, const BeamProperty& property, const Bending& bending, double density,
                      MassKind mass_kind, const LineField& field) {
  if (placed.tapered)
    return density * placed.tapered->section_forces(mass_kind, field) +
           placed.tapered->nonstructural_forces(mass_kind, field);
  const auto of = [&](const LineMass& mass) {
    Vector12 sum = Vector12::Zero();
    if (mass_kind == MassKind::consistent)
      at_gauss_points(placed.length, [&](double s, double weight) {
        sum += weight * forces_at_section(mass, section_motions(property.section, bending, s), s, field);
      });
    else
      for (const int end : {0, 1}) sum += forces_at_end(half_of(mass, placed.length), end, field);
    return sum;
  };
  return density * of(mass_of(property.section)) + of(nonstructural_mass(property));
}

/// End forces of the line about the centroids of the end sections.
Vector12 about_centroids(const Vector12& forces, const BeamProperty& property) {
  Vector12 moved;
  for (const int end : {0, 1}) {
    const Matrix12 carried = axial_at_centroid(-section_at(property, end).centroid).transpose();
    moved.segment<6>(6 * end) = (carried * forces).segment<6>(6 * end);
  }
  return moved;
}

}  // namespace

const char* to_string(BeamPart part) {
  constexpr std::array names = {"", "axial", "bending_y", "bending_z", "bending", "torsion", "stiffness"};
  return names[static_cast<std::size_t>(part)];
}

std::vector<BeamPart> parts_of(const BeamProperty& property) {
  const auto has_hinge = [](const BeamPlacement& placement) {
    return std::ranges::find(placement.released, true) != placement.released.end();
  };
  if (!property.stations.empty() || std::ranges::any_of(property.placements, has_hinge)) return {BeamPart::stiffness};
  if (property.section.product_yz != 0.0) return {BeamPart::axial, BeamPart::bending, BeamPart::torsion};
  return {BeamPart::axial, BeamPart::bending_y, BeamPart::bending_z, BeamPart::torsion};
}

ElementMatrices beam(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                     const BeamPlacement& placement, double poissons_ratio, MassKind mass_kind,
                     const std::vector<BeamPart>& parts) {
  const BeamSection& section = property.section;
  const PlacedBeam placed(ends, property, placement, poissons_ratio);
  const Bending bending(section, placed.length, poissons_ratio);
  const Matrix12 transform = placed.not_released * placed.to_line;
  const auto to_nodes = [&](const Matrix12& local) -> Eigen::MatrixXd {
    const Matrix12 global = transform.transpose() * local * transform;
    return 0.5 * (global + global.transpose());
  };
  const auto stiffness_of = [&](BeamPart part) {
    if (placed.tapered) return placed.tapered->stiffness();
    return local_stiffness(part, section, bending, placed.length, poissons_ratio);
  };
  const auto nodal_mass = [&](const LineMass& mass) {
    return to_nodes(line_mass(mass, property, bending, placed.length, mass_kind));
  };
  ElementMatrices matrices;
  for (const auto part : parts)
    matrices.stiffness.push_back({{.youngs_modulus = 1, .part = part}, to_nodes(stiffness_of(part))});
  if (placed.tapered) {
    matrices.mass = {{{.density = 1}, to_nodes(placed.tapered->section_mass(mass_kind))}};
    if (has_nonstructural_mass(property))
      matrices.mass.push_back({{}, to_nodes(placed.tapered->nonstructural_mass(mass_kind))});
    return matrices;
  }
  matrices.mass = {{{.density = 1}, nodal_mass(mass_of(section))}};
  if (property.nonstructural_mass != 0.0) matrices.mass.push_back({{}, nodal_mass(nonstructural_mass(property))});
  return matrices;
}

Vector12 beam_field_forces(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                           const BeamPlacement& placement, const IsotropicMaterial& material, MassKind mass_kind,
                           const BeamField& field) {
  const PlacedBeam placed(ends, property, placement, material.poissons_ratio);
  const Bending bending(property.section, placed.length, material.poissons_ratio);
  return (placed.not_released * placed.to_line).transpose() *
         field_forces(placed, property, bending, material.density, mass_kind, line_field(field, placed, placement));
}

// With q the motions of the line's ends and f_0 the loads between them, the ends carry K q - f_0. The line's forces act
// at the shear centre; those of the section are counted with the axial force at the centroid, by the inverse transform.
std::array<SectionForces, 2> beam_forces(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                                         const BeamPlacement& placement, const IsotropicMaterial& material,
                                         MassKind mass_kind, const Eigen::VectorXd& motions, const BeamField& field,
                                         const Vector12& loads_at_nodes) {
  const BeamSection& section = property.section;
  const PlacedBeam placed(ends, property, placement, material.poissons_ratio);
  const Bending bending(section, placed.length, material.poissons_ratio);
  const Vector12 line_motions = placed.not_released * (placed.to_line * motions);
  Vector12 loads = placed.not_released.transpose() * field_forces(placed, property, bending, material.density,
                                                                  mass_kind, line_field(field, placed, placement));
  if (!loads_at_nodes.isZero(0.0)) loads += placed.to_line.transpose().partialPivLu().solve(loads_at_nodes);
  const Vector12 elastic =
      material.youngs_modulus *
      centroid_stiffness(BeamPart::none, section, bending, placed.length, material.poissons_ratio) *
      (axial_at_centroid(section.centroid) * line_motions);
  const Vector12 forces =
      placed.tapered
          ? about_centroids(material.youngs_modulus * placed.tapered->stiffness() * line_motions - loads, property)
          : Vector12(elastic - axial_at_centroid(-section.centroid).transpose() * loads);
  return {SectionForces(-forces.head<6>()), SectionForces(forces.tail<6>())};
}

Eigen::MatrixXd beam_geometric_stiffness(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                                         const BeamPlacement& placement, double poissons_ratio, double axial_force) {
  const PlacedBeam placed(ends, property, placement, poissons_ratio);
  const Bending bending(property.section, placed.length, poissons_ratio);
  Matrix12 local = Matrix12::Zero();
  at_gauss_points(placed.length, [&](double s, double weight) {
    const Pair slopes = bending.deflection_slopes(s);
    local += weight * axial_force * slopes.transpose() * slopes;
  });
  if (placed.tapered) local = axial_force * placed.tapered->geometric_stiffness();
  const Matrix12 transform = placed.not_released * placed.to_line;
  return transform.transpose() * local * transform;
}

// sigma = N / A + a y + b z with M_y = int z sigma dA and M_z = -int y sigma dA.
namespace {

/// d sigma / d[y z] of the bending moments.
Eigen::Vector2d stress_slope(const SectionForces& forces, const BeamSection& section) {
  const Eigen::Matrix2d moments{{section.product_yz, section.inertia_y}, {-section.inertia_z, -section.product_yz}};
  return moments.inverse() * forces.tail<2>();
}

}  // namespace

double axial_stress(const SectionForces& forces, const BeamSection& section, const Eigen::Vector2d& place) {
  return forces[0] / section.area + stress_slope(forces, section).dot(place);
}

std::optional<FibreStress> fibre_stress(const SectionForces& forces, const BeamSection& section) {
  const auto& [corners, radius] = section.outline;
  if (corners.empty() && radius == 0.0) return std::nullopt;
  const Eigen::Vector2d slope = stress_slope(forces, section);
  const double axial = forces[0] / section.area;
  if (corners.empty()) return FibreStress{axial - radius * slope.norm(), axial + radius * slope.norm()};
  FibreStress stress{axial + slope.dot(corners.front()), axial + slope.dot(corners.front())};
  for (const auto& corner : corners) {
    stress.lowest = std::min(stress.lowest, axial + slope.dot(corner));
    stress.highest = std::max(stress.highest, axial + slope.dot(corner));
  }
  return stress;
}

}  // namespace kalfem
