// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/load_case.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "kalfem/model/statics/rotation.hpp"

namespace kalfem {
namespace {

using FaceNodes = Eigen::Matrix3Xd;

/// Shape functions of a face at a natural place, and their slopes along r and s.
struct FaceFunctions {
  Eigen::VectorXd values;
  Eigen::MatrixX2d slopes;
};

/// Natural coordinates: 0 <= r, s, r + s <= 1 of triangles, -1 <= r, s <= 1 of quadrilaterals. The quadratic shapes are
/// the linear ones L_i with the sides' middles: 4 L_i L_j of a triangle, serendipity functions of a quadrilateral.
FaceFunctions triangle_functions(double r, double s, bool quadratic) {
  const Eigen::Vector3d corner(1.0 - r - s, r, s);
  const Eigen::Matrix<double, 3, 2> slope{{-1.0, -1.0}, {1.0, 0.0}, {0.0, 1.0}};
  if (!quadratic) return {corner, slope};
  FaceFunctions functions{Eigen::VectorXd(6), Eigen::MatrixX2d(6, 2)};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    functions.values[i] = corner[i] * (2.0 * corner[i] - 1.0);
    functions.slopes.row(i) = (4.0 * corner[i] - 1.0) * slope.row(i);
    functions.values[3 + i] = 4.0 * corner[i] * corner[j];
    functions.slopes.row(3 + i) = 4.0 * (corner[i] * slope.row(j) + corner[j] * slope.row(i));
  }
  return functions;
}

FaceFunctions quadrilateral_functions(double r, double s, bool quadratic) {
  constexpr std::array<double, 4> corner_r = {-1.0, 1.0, 1.0, -1.0}, corner_s = {-1.0, -1.0, 1.0, 1.0};
  const int count = quadratic ? 8 : 4;
  FaceFunctions functions{Eigen::VectorXd(count), Eigen::MatrixX2d(count, 2)};
  for (int i = 0; i < 4; ++i) {
    const double a = corner_r[static_cast<std::size_t>(i)], b = corner_s[static_cast<std::size_t>(i)];
    functions.values[i] = 0.25 * (1.0 + a * r) * (1.0 + b * s);
    functions.slopes.row(i) << 0.25 * a * (1.0 + b * s), 0.25 * b * (1.0 + a * r);
  }
  if (!quadratic) return functions;
  const auto set_middle = [&](int i, double value, double along_r, double along_s) {
    functions.values[i] = value;
    functions.slopes.row(i) << along_r, along_s;
  };
  set_middle(4, 0.5 * (1.0 - r * r) * (1.0 - s), -r * (1.0 - s), -0.5 * (1.0 - r * r));
  set_middle(5, 0.5 * (1.0 + r) * (1.0 - s * s), 0.5 * (1.0 - s * s), -s * (1.0 + r));
  set_middle(6, 0.5 * (1.0 - r * r) * (1.0 + s), -r * (1.0 + s), 0.5 * (1.0 - r * r));
  set_middle(7, 0.5 * (1.0 - r) * (1.0 - s * s), -0.5 * (1.0 - s * s), -s * (1.0 - r));
  for (int i = 0; i < 4; ++i)
    for (const int side : {4 + i, 4 + (i + 3) % 4}) {
      functions.values[i] -= 0.5 * functions.values[side];
      functions.slopes.row(i) -= 0.5 * functions.slopes.row(side);
    }
  return functions;
}

/// Gauss's rule of three points on [-1, 1].
constexpr std::array<double, 3> gauss_places = {-0.7745966692414834, 0.0, 0.7745966692414834};
constexpr std::array<double, 3> gauss_weights = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

/// int N_i n dA, 3 x nodes: by 3 x 3 points, which a triangle takes on the square that collapses to it.
Eigen::Matrix3Xd area_shares(CellShape shape, const FaceNodes& places) {
  const bool quadratic = node_count(shape) > corner_count(shape);
  Eigen::Matrix3Xd shares = Eigen::Matrix3Xd::Zero(3, places.cols());
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double weight = gauss_weights[i] * gauss_weights[j];
      const bool is_triangle = corner_count(shape) == 3;
      const double a = 0.5 * (1.0 + gauss_places[i]), b = 0.5 * (1.0 + gauss_places[j]);
      const FaceFunctions at = is_triangle ? triangle_functions(a, b * (1.0 - a), quadratic)
                                           : quadrilateral_functions(gauss_places[i], gauss_places[j], quadratic);
      const Eigen::Matrix<double, 3, 2> tangents = places * at.slopes;
      const Eigen::Vector3d area = Eigen::Vector3d(tangents.col(0)).cross(Eigen::Vector3d(tangents.col(1)));
      shares += weight * (is_triangle ? 0.25 * (1.0 - a) : 1.0) * area * at.values.transpose();
    }
  return shares;
}

/// int N_i over a cell of size 1, of a corner or a middle node.
double uniform_share(CellShape shape, bool is_corner) {
  switch (shape) {
    case CellShape::line3:
      return is_corner ? 1.0 / 6.0 : 2.0 / 3.0;
    case CellShape::triangle6:
      return is_corner ? 0.0 : 1.0 / 3.0;
    case CellShape::quadrilateral8:
      return is_corner ? -1.0 / 12.0 : 1.0 / 3.0;
    default:
      return 1.0 / node_count(shape);
  }
}

}  // namespace

std::map<Eigen::Index, double> uniform_shares(const Mesh& mesh, const std::vector<Eigen::Index>& cells) {
  std::map<Eigen::Index, double> shares;
  double total = 0.0;
  for (const auto index : cells) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(index)];
    const auto nodes = mesh.nodes_of(cell);
    const double size = dimension(cell.shape) == 0 ? 1.0 : std::abs(cell_measure(mesh, cell));
    for (std::size_t i = 0; i < nodes.size(); ++i)
      shares[nodes[i]] += size * uniform_share(cell.shape, static_cast<int>(i) < corner_count(cell.shape));
    total += size;
  }
  for (auto& [node, share] : shares) share /= total;
  return shares;
}

AccelerationField LoadCase::field() const {
  AccelerationField field = gravity;
  if (rotation) field += centrifugal_field(*rotation);
  return field;
}

bool is_empty(const LoadCase& load_case) {
  return load_case.loads.empty() && load_case.pressures.empty() && load_case.imposed.empty() &&
         load_case.beam_loads.empty() && load_case.gravity.isZero(0.0) && !load_case.rotation;
}

namespace {

// A constant force p per length gives the nodes of a quadratic side of the length l the forces p l [1, 4, 1] / 6, those
// of the two linear sides in its place p l [1, 2, 1] / 4: a force at the middle acts with 3/4 there and 1/8 at each
// end.
void add_force(const FiniteElementModel& model, Eigen::Index node, const Eigen::Vector3d& force,
               Eigen::VectorXd& forces) {
  const auto side = model.side_middles.find(node);
  const double own = side == model.side_middles.end() ? 1.0 : 0.75;
  forces.segment<3>(6 * node) += own * force;
  if (side != model.side_middles.end())
    for (const auto end : side->second) forces.segment<3>(6 * end) += 0.125 * force;
}

}  // namespace

Eigen::VectorXd nodal_forces(const FiniteElementModel& model, const LoadCase& load_case) {
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(6 * model.mesh.node_count());
  for (const auto& load : load_case.loads) {
    add_force(model, load.node, load.force, forces);
    forces.segment<3>(6 * load.node + 3) += load.moment;
  }
  for (const auto& [cell, ends] : load_case.beam_loads) {
    const auto nodes = model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]);
    for (std::size_t i = 0; i < 2; ++i)
      forces.segment<6>(6 * nodes[i]) += ends.segment<6>(6 * static_cast<Eigen::Index>(i));
  }
  for (const auto& [faces, pressure] : load_case.pressures)
    for (const auto& face : faces) {
      const std::span nodes(face.nodes.data(), static_cast<std::size_t>(node_count(face.shape)));
      const Eigen::Matrix3Xd shares = area_shares(face.shape, model.mesh.nodes(Eigen::all, nodes));
      for (std::size_t i = 0; i < nodes.size(); ++i)
        forces.segment<3>(6 * nodes[i]) -= pressure * shares.col(static_cast<Eigen::Index>(i));
    }
  return forces;
}

}  // namespace kalfem
