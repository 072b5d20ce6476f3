#include "kalfem/model/elements/solid_shapes.hpp"

#include <array>

#include "kalfem/model/mesh/cell_corners.hpp"

namespace kalfem {
namespace {

/// A function of the place with its gradient: products and sums follow the rules of differentiation.
struct Function {
  double value = 0.0;
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
};

Function operator+(const Function& a, const Function& b) { return {a.value + b.value, a.slope + b.slope}; }
Function operator+(double a, const Function& b) { return {a + b.value, b.slope}; }
Function operator-(double a, const Function& b) { return {a - b.value, -b.slope}; }
Function operator*(double a, const Function& b) { return {a * b.value, a * b.slope}; }
Function operator*(const Function& a, const Function& b) {
  return {a.value * b.value, a.value * b.slope + b.value * a.slope};
}

/// Natural coordinates of a place as functions.
std::array<Function, 3> coordinates(const Eigen::Vector3d& place) {
  return {{{place[0], Eigen::Vector3d::UnitX()},
           {place[1], Eigen::Vector3d::UnitY()},
           {place[2], Eigen::Vector3d::UnitZ()}}};
}

Function tetrahedron_function(const Eigen::Vector3d& place, int node, bool quadratic) {
  const auto [r, s, t] = coordinates(place);
  const std::array<Function, 4> volumes = {1.0 - (r + s + t), r, s, t};
  const auto volume = [&](int corner) { return volumes[static_cast<std::size_t>(corner)]; };
  if (node >= 4) {
    const auto [a, b] = corner_sides(CellShape::tetrahedron10)[static_cast<std::size_t>(node - 4)];
    return 4.0 * volume(a) * volume(b);
  }
  return quadratic ? volume(node) * (-1.0 + 2.0 * volume(node)) : volume(node);
}

Function wedge_function(const Eigen::Vector3d& place, int node, bool quadratic) {
  const auto [r, s, t] = coordinates(place);
  const std::array<Function, 3> areas = {1.0 - (r + s), r, s};
  const auto area = [&](int corner) { return areas[static_cast<std::size_t>(corner % 3)]; };
  const auto toward = [&](int corner) { return corner < 3 ? 1.0 - t : 1.0 + t; };
  if (node < 6) {
    const Function linear = 0.5 * (area(node) * toward(node));
    return quadratic ? linear * (-3.0 + 2.0 * area(node) + toward(node)) : linear;
  }
  const auto [a, b] = corner_sides(CellShape::wedge15)[static_cast<std::size_t>(node - 6)];
  return node < 12 ? 2.0 * area(a) * area(b) * toward(a) : area(a) * (1.0 - t * t);
}

Function hexahedron_function(const Eigen::Vector3d& place, int node, bool quadratic) {
  const Eigen::Vector3d own = natural_nodes(quadratic ? CellShape::hexahedron20 : CellShape::hexahedron8).col(node);
  Function product{1.0}, sum{-2.0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Function along = coordinates(place)[axis];
    const double end = own[static_cast<Eigen::Index>(axis)];
    product = product * (end == 0.0 ? 1.0 - along * along : 0.5 * (1.0 + end * along));
    sum = sum + end * along;
  }
  if (!quadratic) return product;
  return node < 8 ? product * sum : product;
}

Function shape_function(CellShape shape, const Eigen::Vector3d& place, int node) {
  switch (shape) {
    case CellShape::tetrahedron4:
      return tetrahedron_function(place, node, false);
    case CellShape::tetrahedron10:
      return tetrahedron_function(place, node, true);
    case CellShape::wedge6:
      return wedge_function(place, node, false);
    case CellShape::wedge15:
      return wedge_function(place, node, true);
    case CellShape::hexahedron8:
      return hexahedron_function(place, node, false);
    default:
      return hexahedron_function(place, node, true);
  }
}

SolidNodes corner_nodes(CellShape shape) {
  SolidNodes corners(3, corner_count(shape));
  switch (corner_count(shape)) {
    case 4:
      corners << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
      break;
    case 6:
      corners << 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, -1, -1, -1, 1, 1, 1;
      break;
    default:
      corners << -1, 1, 1, -1, -1, 1, 1, -1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1, -1, -1, 1, 1, 1, 1;
      break;
  }
  return corners;
}

}  // namespace

ShapeFunctions solid_shape_functions(CellShape shape, const Eigen::Vector3d& place) {
  const int nodes = node_count(shape);
  ShapeFunctions functions{ShapeVector(nodes), ShapeSlopes(nodes, 3)};
  for (int i = 0; i < nodes; ++i) {
    const Function function = shape_function(shape, place, i);
    functions.values[i] = function.value;
    functions.slopes.row(i) = function.slope;
  }
  return functions;
}

SolidNodes natural_nodes(CellShape shape) {
  const SolidNodes corners = corner_nodes(shape);
  SolidNodes nodes(3, node_count(shape));
  nodes.leftCols(corners.cols()) = corners;
  Eigen::Index column = corners.cols();
  if (nodes.cols() > column)  // middle nodes
    for (const auto& [a, b] : corner_sides(shape)) nodes.col(column++) = 0.5 * (corners.col(a) + corners.col(b));
  return nodes;
}

}  // namespace kalfem
