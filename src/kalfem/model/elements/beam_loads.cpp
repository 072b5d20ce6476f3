// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/beam_loads.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "kalfem/model/elements/tapered_beam.hpp"

namespace kalfem {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Ends = Eigen::Matrix<double, 3, 2>;

/// The stations of a tapered beam between two shares of its length.
std::vector<BeamStation> part_of(const std::vector<BeamStation>& stations, double from, double to) {
  std::vector<BeamStation> part;
  if (stations.empty()) return part;
  part.push_back(station_at(stations, from));
  for (const auto& station : stations)
    if (station.place > from && station.place < to) part.push_back(station);
  part.push_back(station_at(stations, to));
  for (auto& station : part) station.place = std::clamp((station.place - from) / (to - from), 0.0, 1.0);
  part.front().place = 0.0, part.back().place = 1.0;
  return part;
}

/// Stiffness per unit E of the bare line between two shares of its length, without hinges and offsets.
Matrix12 line_stiffness(const Ends& line, double from, double to, BeamProperty property, const BeamPlacement& placement,
                        double poissons_ratio) {
  property.stations = part_of(property.stations, from, to);
  Ends ends;
  ends << (1.0 - from) * line.col(0) + from * line.col(1), (1.0 - to) * line.col(0) + to * line.col(1);
  return beam(ends, property, {.up = placement.up, .offsets = Ends::Zero(), .released = {}}, poissons_ratio,
              MassKind::lumped)
      .stiffness.front()
      .matrix;
}

/// At the ends of the line, which hold: what two beams that meet under the load pass on to them.
Vector12 at_line_ends(const Ends& line, const BeamProperty& property, const BeamPlacement& placement,
                      double poissons_ratio, double at, const Vector6& load) {
  constexpr double near = 1e-9;
  Vector12 forces = Vector12::Zero();
  if (at < near || at > 1.0 - near) {
    forces.segment<6>(at < 0.5 ? 0 : 6) = load;
    return forces;
  }
  const Matrix12 before = line_stiffness(line, 0.0, at, property, placement, poissons_ratio),
                 behind = line_stiffness(line, at, 1.0, property, placement, poissons_ratio);
  const Eigen::Matrix<double, 6, 6> own = before.bottomRightCorner<6, 6>() + behind.topLeftCorner<6, 6>();
  const Vector6 motion = own.ldlt().solve(load);
  forces << -before.topRightCorner<6, 6>() * motion, -behind.bottomLeftCorner<6, 6>() * motion;
  return forces;
}

/// Hinges pass nothing on: f_a - K_ar K_rr^-1 f_r of the motions a that are kept, in local axes.
Vector12 without_hinges(const Matrix12& stiffness, const std::array<bool, 12>& released, Vector12 forces) {
  std::vector<int> free, kept;
  for (int i = 0; i < 12; ++i) (released[static_cast<std::size_t>(i)] ? free : kept).push_back(i);
  if (free.empty()) return forces;
  const Eigen::MatrixXd own = stiffness(free, free);
  const Eigen::VectorXd motion = own.completeOrthogonalDecomposition().solve(Eigen::VectorXd(forces(free)));
  forces(kept) -= stiffness(kept, free) * motion;
  forces(free).setZero();
  return forces;
}

Matrix12 in_blocks(const Eigen::Matrix3d& axes) {
  Matrix12 blocks = Matrix12::Zero();
  for (const int i : {0, 3, 6, 9}) blocks.block<3, 3>(i, i) = axes;
  return blocks;
}

}  // namespace

Eigen::Matrix3d beam_axes(const Ends& ends, const BeamPlacement& placement) {
  const Eigen::Vector3d x =
      (ends.col(1) + placement.offsets.col(1) - ends.col(0) - placement.offsets.col(0)).normalized();
  Eigen::Vector3d across = placement.up - placement.up.dot(x) * x;
  if (!(across.norm() > 1e-6 * placement.up.norm())) across = x.unitOrthogonal();
  const Eigen::Vector3d z = across.normalized();
  Eigen::Matrix3d axes;
  axes << x.transpose(), z.cross(x).transpose(), z.transpose();
  return axes;
}

Vector12 nodal_forces_of_point_load(const Ends& ends, const BeamProperty& property, const BeamPlacement& placement,
                                    double poissons_ratio, double at, const Vector6& load) {
  const Ends line = ends + placement.offsets;
  Vector12 forces = at_line_ends(line, property, placement, poissons_ratio, at, load);
  const Matrix12 axes = in_blocks(beam_axes(ends, placement));
  const Matrix12 stiffness =
      axes * line_stiffness(line, 0.0, 1.0, property, placement, poissons_ratio) * axes.transpose();
  forces = axes.transpose() * without_hinges(stiffness, placement.released, axes * forces);
  for (const int end : {0, 1})
    forces.segment<3>(6 * end + 3) +=
        Eigen::Vector3d(placement.offsets.col(end)).cross(Eigen::Vector3d(forces.segment<3>(6 * end)));
  return forces;
}

Vector12 nodal_forces_of_line_load(const Ends& ends, const BeamProperty& property, const BeamPlacement& placement,
                                   double poissons_ratio, const LineLoad& load) {
  // Gauss's rule of three points: the shapes are cubic and the load is linear.
  constexpr std::array<double, 3> points = {-0.7745966692414834, 0.0, 0.7745966692414834};
  constexpr std::array<double, 3> weights = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  const double length = (ends.col(1) + placement.offsets.col(1) - ends.col(0) - placement.offsets.col(0)).norm();
  const auto& [from, to] = load.places;
  Vector12 forces = Vector12::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double share = 0.5 * (1.0 + points[i]);
    const Vector6 value =
        0.5 * weights[i] * (to - from) * length * ((1.0 - share) * load.values.col(0) + share * load.values.col(1));
    forces += nodal_forces_of_point_load(ends, property, placement, poissons_ratio, from + share * (to - from), value);
  }
  return forces;
}

}  // namespace kalfem
