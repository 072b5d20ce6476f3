// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/tapered_beam.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace kalfem {
namespace {

using Matrix6 = TaperedLine::Matrix6;

// Gauss's rule of six points on [0, 1]. Over a part in which no property more than doubles the integrals of their
// inverses are exact to 1e-9.
constexpr std::array places = {0.033765242898424, 0.169395306766868, 0.380690406958402,
                               0.619309593041598, 0.830604693233132, 0.966234757101576};
constexpr std::array weights = {0.085662246189585, 0.180380786524069, 0.233956967286346,
                                0.233956967286346, 0.180380786524069, 0.085662246189585};
constexpr int deepest = 20;  ///< halvings of a part

template <class Value>
Value between(const Value& a, const Value& b, double share) {
  return (1.0 - share) * a + share * b;
}

SectionOutline between(const SectionOutline& a, const SectionOutline& b, double share) {
  if (a.corners.size() != b.corners.size()) return {};
  SectionOutline outline{.corners = a.corners, .radius = between(a.radius, b.radius, share)};
  for (std::size_t i = 0; i < a.corners.size(); ++i) outline.corners[i] = between(a.corners[i], b.corners[i], share);
  return outline;
}

BeamSection between(const BeamSection& a, const BeamSection& b, double share) {
  const auto of = [&](auto member) { return between(a.*member, b.*member, share); };
  return {.area = of(&BeamSection::area),
          .inertia_y = of(&BeamSection::inertia_y),
          .inertia_z = of(&BeamSection::inertia_z),
          .torsion = of(&BeamSection::torsion),
          .shear_factor_y = of(&BeamSection::shear_factor_y),
          .shear_factor_z = of(&BeamSection::shear_factor_z),
          .product_yz = of(&BeamSection::product_yz),
          .centroid = between(a.centroid, b.centroid, share),
          .outline = between(a.outline, b.outline, share)};
}

BeamStation between(const BeamStation& a, const BeamStation& b, double share) {
  return {.place = between(a.place, b.place, share),
          .section = between(a.section, b.section, share),
          .nonstructural_mass = between(a.nonstructural_mass, b.nonstructural_mass, share),
          .nonstructural_inertia = between(a.nonstructural_inertia, b.nonstructural_inertia, share),
          .nonstructural_centre = between(a.nonstructural_centre, b.nonstructural_centre, share)};
}

/// Carries a force at the end of the distance d to its start; its transpose, motions of the start to its end.
Matrix6 carry(double distance) {
  Matrix6 carried = Matrix6::Identity();
  carried(4, 2) = -distance;
  carried(5, 1) = distance;
  return carried;
}

bool more_than_doubles(const BeamSection& a, const BeamSection& b) {
  for (const auto member : {&BeamSection::area, &BeamSection::inertia_y, &BeamSection::inertia_z, &BeamSection::torsion,
                            &BeamSection::shear_factor_y, &BeamSection::shear_factor_z})
    if (std::max(a.*member, b.*member) > 2.0 * std::min(a.*member, b.*member)) return true;
  return false;
}

LineMass mass_of_section(const BeamStation& station) { return mass_of(station.section); }
LineMass mass_beside_section(const BeamStation& station) {
  return {.amount = station.nonstructural_mass,
          .place = station.nonstructural_centre,
          .polar = station.nonstructural_inertia};
}

}  // namespace

BeamStation station_at(const std::vector<BeamStation>& stations, double place) {
  auto after = std::ranges::upper_bound(stations, place, {}, &BeamStation::place);
  after = std::clamp(after, stations.begin() + 1, stations.end() - 1);
  const auto& a = *std::prev(after);
  return between(a, *after, (place - a.place) / (after->place - a.place));
}

BeamSection section_at(const BeamProperty& property, double place) {
  return property.stations.empty() ? property.section : station_at(property.stations, place).section;
}

BeamStation mean_station(const std::vector<BeamStation>& stations) {
  BeamStation mean = stations.front();
  double covered = 0.0;
  for (std::size_t i = 1; i < stations.size(); ++i) {
    const double length = stations[i].place - stations[i - 1].place;
    covered += length;
    mean = between(mean, between(stations[i - 1], stations[i], 0.5), length / covered);
  }
  return mean;
}

TaperedLine::TaperedLine(const std::vector<BeamStation>& stations, double length, double poissons_ratio,
                         LumpedInertia lumped_inertia)
    : stations_(stations), length_(length), poissons_ratio_(poissons_ratio), lumped_inertia_(lumped_inertia) {
  std::vector<Part> parts;
  const auto divide = [&](const auto& self, double from, double to, int depth) -> void {
    if (depth < deepest && more_than_doubles(station_at(stations, from).section, station_at(stations, to).section)) {
      const double middle = 0.5 * (from + to);
      self(self, from, middle, depth + 1);
      self(self, middle, to, depth + 1);
    } else {
      parts.push_back({from, to});
    }
  };
  for (std::size_t i = 1; i < stations.size(); ++i) divide(divide, stations[i - 1].place, stations[i].place, 0);

  std::vector<Matrix6> reached = {Matrix6::Zero()};  // G at the starts of the parts, and F at the end
  for (const auto& [from, to] : parts)
    reached.push_back(carry((to - from) * length).transpose() * reached.back() + flexibility(from, to, to));
  SectionMotions relative;
  relative << -carry(length).transpose(), Matrix6::Identity();
  const Matrix6 inverse = reached.back().inverse();
  const SectionMotions loads = 0.5 * (inverse + inverse.transpose()) * relative;
  stiffness_ = relative.transpose() * loads;
  for (std::size_t i = 0; i < parts.size(); ++i) add_points(parts[i], reached[i], loads);
}

/// Strains [epsilon gamma_y gamma_z kappa_x kappa_y kappa_z] of the line by the forces [N V_y V_z T M_y M_z] about it.
Matrix6 TaperedLine::compliance(const BeamSection& section) const {
  const double turned = 2.0 * (1.0 + poissons_ratio_);
  const auto sheared = [&](double factor) { return factor == 0.0 ? 0.0 : turned / (factor * section.area); };
  Eigen::Matrix3d about_centroid{{1.0 / section.area, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  about_centroid.bottomRightCorner<2, 2>() =
      Eigen::Matrix2d{{section.inertia_y, -section.product_yz}, {-section.product_yz, section.inertia_z}}.inverse();
  // epsilon at the centroid is that of the line + z_c kappa_y - y_c kappa_z.
  const Eigen::Matrix3d to_line{{1.0, -section.centroid.y(), section.centroid.x()}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  const Eigen::Matrix3d bent = to_line * about_centroid * to_line.transpose();
  Matrix6 compliance = Matrix6::Zero();
  constexpr std::array axes = {0, 4, 5};
  compliance(axes, axes) = bent;
  compliance(1, 1) = sheared(section.shear_factor_y);
  compliance(2, 2) = sheared(section.shear_factor_z);
  compliance(3, 3) = turned / section.torsion;
  return compliance;
}

/// int H(x - xi)^T c H(L - xi) dxi between two places of one part, x at `up_to`.
Matrix6 TaperedLine::flexibility(double from, double to, double up_to) const {
  Matrix6 sum = Matrix6::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double place = between(from, to, places[i]);
    sum += weights[i] * (to - from) * length_ * carry((up_to - place) * length_).transpose() *
           compliance(station_at(stations_, place).section) * carry((1.0 - place) * length_);
  }
  return sum;
}

void TaperedLine::add_points(const Part& part, const Matrix6& before, const SectionMotions& loads) {
  SectionMotions start = SectionMotions::Zero();
  start.leftCols<6>().setIdentity();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double place = between(part.from, part.to, places[i]);
    Point point{.station = station_at(stations_, place),
                .weight = weights[i] * (part.to - part.from) * length_,
                .motions = {},
                .slopes = {}};
    const Matrix6 reached =
        carry((place - part.from) * length_).transpose() * before + flexibility(part.from, place, place);
    point.motions = carry(place * length_).transpose() * start + reached * loads;
    const SectionMotions strains = compliance(point.station.section) * carry((1.0 - place) * length_) * loads;
    point.slopes << point.motions.row(5) + strains.row(1), strains.row(2) - point.motions.row(4);
    points_.push_back(std::move(point));
  }
}

TaperedLine::Matrix12 TaperedLine::geometric_stiffness() const {
  Matrix12 sum = Matrix12::Zero();
  for (const auto& point : points_) sum += point.weight * point.slopes.transpose() * point.slopes;
  return sum;
}

TaperedLine::Matrix12 TaperedLine::mass(MassAt mass_at, MassKind kind) const {
  Matrix12 sum = Matrix12::Zero();
  if (kind == MassKind::consistent)
    for (const auto& point : points_) sum += point.weight * mass_at_section(mass_at(point.station), point.motions);
  else
    for (const int end : {0, 1}) sum += mass_at_end(mass_of_end(mass_at, end), end, length_, lumped_inertia_);
  return sum;
}

LineMass TaperedLine::mass_of_end(MassAt mass_at, int end) const {
  LineMass own;
  for (const auto& point : points_) {
    const double share = point.weight * (end == 0 ? 1.0 - point.station.place : point.station.place);
    const LineMass line = mass_at(point.station);
    own.amount += share * line.amount;
    own.polar += share * line.polar;
    own.place += share * line.amount * line.place;
    own.rotary += share * line.rotary;
  }
  if (own.amount > 0.0) own.place /= own.amount;
  return own;
}

TaperedLine::Vector12 TaperedLine::forces(MassAt mass_at, MassKind kind, const LineField& field) const {
  Vector12 sum = Vector12::Zero();
  if (kind == MassKind::consistent)
    for (const auto& point : points_)
      sum += point.weight * forces_at_section(mass_at(point.station), point.motions, point.station.place, field);
  else
    for (const int end : {0, 1}) sum += forces_at_end(mass_of_end(mass_at, end), end, field);
  return sum;
}

TaperedLine::Matrix12 TaperedLine::section_mass(MassKind kind) const { return mass(mass_of_section, kind); }
TaperedLine::Matrix12 TaperedLine::nonstructural_mass(MassKind kind) const { return mass(mass_beside_section, kind); }
TaperedLine::Vector12 TaperedLine::section_forces(MassKind kind, const LineField& field) const {
  return forces(mass_of_section, kind, field);
}
TaperedLine::Vector12 TaperedLine::nonstructural_forces(MassKind kind, const LineField& field) const {
  return forces(mass_beside_section, kind, field);
}

}  // namespace kalfem
