// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/gauges/nearest_place.hpp"

#include <algorithm>
#include <limits>

#include "kalfem/model/elements/solid_strains.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// N_i of the corners and their slopes along r, s and t, corners x 3.
struct CornerFunctions {
  Eigen::VectorXd values;
  Eigen::MatrixX3d slopes;
};

CornerFunctions line_functions(double r) {
  CornerFunctions line{Eigen::Vector2d(0.5 * (1.0 - r), 0.5 * (1.0 + r)), Eigen::MatrixX3d::Zero(2, 3)};
  line.slopes.col(0) << -0.5, 0.5;
  return line;
}

CornerFunctions triangle_functions(double r, double s) {
  CornerFunctions triangle{Vector3d(1.0 - r - s, r, s), Eigen::MatrixX3d::Zero(3, 3)};
  triangle.slopes.col(0) << -1.0, 1.0, 0.0;
  triangle.slopes.col(1) << -1.0, 0.0, 1.0;
  return triangle;
}

CornerFunctions quadrilateral_functions(double r, double s) {
  const Eigen::Array4d r_i(-1.0, 1.0, 1.0, -1.0), s_i(-1.0, -1.0, 1.0, 1.0);
  CornerFunctions four{0.25 * (1.0 + r_i * r) * (1.0 + s_i * s), Eigen::MatrixX3d::Zero(4, 3)};
  four.slopes.col(0) = 0.25 * r_i * (1.0 + s_i * s);
  four.slopes.col(1) = 0.25 * (1.0 + r_i * r) * s_i;
  return four;
}

CornerFunctions corner_functions(CellShape shape, const Vector3d& natural) {
  if (dimension(shape) == 1) return line_functions(natural[0]);
  if (dimension(shape) == 2)
    return corner_count(shape) == 3 ? triangle_functions(natural[0], natural[1])
                                    : quadrilateral_functions(natural[0], natural[1]);
  const ShapeFunctions solid = solid_shape_functions(linear_shape(shape), natural);
  return {solid.values, solid.slopes};
}

/// Coordinates that are shares of a simplex, which sum to 1 at most; the others lie in [-1, 1].
int simplex_coordinates(CellShape shape) {
  if (dimension(shape) == 2) return corner_count(shape) == 3 ? 2 : 0;
  if (dimension(shape) == 3 && corner_count(shape) == 4) return 3;
  return dimension(shape) == 3 && corner_count(shape) == 6 ? 2 : 0;
}

/// The coordinates pulled back into the cell.
Vector3d inside(CellShape shape, const Vector3d& natural) {
  const int simplex = simplex_coordinates(shape);
  Vector3d kept = natural.cwiseMax(-1.0).cwiseMin(1.0);
  auto shares = kept.head(simplex);
  shares = shares.cwiseMax(0.0);
  if (simplex > 0 && shares.sum() > 1.0) shares /= shares.sum();
  return kept;
}

/// Gauss-Newton steps on |x(r) - place|^2, each pulled back into the cell.
CellPlace nearest_place(const Mesh& mesh, Index index, const Vector3d& place) {
  constexpr int most_steps = 50;
  const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
  const Eigen::Matrix3Xd corners = corner_places(mesh, cell);
  const auto at = [&](const Vector3d& natural) -> Vector3d {
    return corners * corner_functions(cell.shape, natural).values;
  };
  CellPlace nearest{index, natural_centre(cell.shape), 0.0};
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::Matrix3d tangents = corners * corner_functions(cell.shape, nearest.natural).slopes;
    const Vector3d missing = place - at(nearest.natural);
    const Vector3d next =
        inside(cell.shape, nearest.natural + tangents.completeOrthogonalDecomposition().solve(missing));
    const double change = (next - nearest.natural).norm();
    nearest.natural = next;
    if (change < 1e-13) break;
  }
  nearest.distance = (at(nearest.natural) - place).norm();
  return nearest;
}

/// Centre and radius of a sphere around the corners.
std::pair<Vector3d, double> sphere_around(const Mesh& mesh, const Cell& cell) {
  const Eigen::Matrix3Xd corners = corner_places(mesh, cell);
  const Vector3d centre = corners.rowwise().mean();
  return {centre, (corners.colwise() - centre).colwise().norm().maxCoeff()};
}

}  // namespace

Eigen::VectorXd corner_shares(CellShape shape, const Vector3d& natural) {
  return corner_functions(shape, natural).values;
}

Vector3d natural_centre(CellShape shape) {
  Vector3d centre = Vector3d::Zero();
  const int simplex = simplex_coordinates(shape);
  centre.head(simplex).setConstant(1.0 / (simplex + 1.0));
  return centre;
}

// Only cells whose sphere reaches nearer than the farthest point of the nearest sphere can hold the nearest place.
std::vector<CellPlace> nearest_places(const Mesh& mesh, std::span<const Index> cells, const Vector3d& place) {
  std::vector<double> nearest_possible;
  double bound = std::numeric_limits<double>::infinity(), size = 0.0;
  for (const Index index : cells) {
    const auto [centre, radius] = sphere_around(mesh, mesh.cells[static_cast<std::size_t>(index)]);
    const double distance = (centre - place).norm();
    nearest_possible.push_back(distance - radius);
    if (distance + radius < bound) {
      bound = distance + radius;
      size = radius;
    }
  }
  std::vector<CellPlace> found;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (nearest_possible[i] <= bound) found.push_back(nearest_place(mesh, cells[i], place));
  if (found.empty()) return found;
  const double least = std::ranges::min(found, {}, &CellPlace::distance).distance, rounding = 1e-6 * size;
  std::erase_if(found, [&](const CellPlace& each) { return each.distance > least + rounding; });
  return found;
}

}  // namespace kalfem
