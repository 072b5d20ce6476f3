// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/elements/solid.hpp"
#include "kalfem/model/mesh/mesh.hpp"

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

// Shape functions are written once, as products of the coordinates that are one at a corner and zero at the opposite
// face; `Function` carries the gradient along, so no derivative is written by hand. A middle node's function is
// a product of its two corners'; a quadratic corner's is the linear one, corrected to vanish at the middle nodes.
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

namespace {

struct WeightedPlace {
  Eigen::Vector3d place;
  double weight = 0.0;
};
using Points = std::vector<WeightedPlace>;

/// Gauss points on -1 <= t <= 1.
std::vector<std::pair<double, double>> gauss(int count) {
  switch (count) {
    case 1:
      return {{0.0, 2.0}};
    case 2:
      return {{-std::sqrt(1.0 / 3.0), 1.0}, {std::sqrt(1.0 / 3.0), 1.0}};
    case 3:
      return {{-std::sqrt(0.6), 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {std::sqrt(0.6), 5.0 / 9.0}};
    default: {
      const double root = std::sqrt(4.8), near = std::sqrt((3.0 - root) / 7.0), far = std::sqrt((3.0 + root) / 7.0);
      const double more = 0.5 + std::sqrt(30.0) / 36.0, less = 0.5 - std::sqrt(30.0) / 36.0;
      return {{-far, less}, {-near, more}, {near, more}, {far, less}};
    }
  }
}

/// Three points at (b, b), (a, b) and (b, a) with a = 1 - 2 b.
void add_triple(Points& places, double b, double weight) {
  const double a = 1.0 - 2.0 * b;
  for (const auto& [r, s] : {std::pair{b, b}, std::pair{a, b}, std::pair{b, a}})
    places.push_back({{r, s, 0.0}, weight});
}

/// Points of degree 1, 2 or 5 on the triangle.
Points triangle_points(int count) {
  Points places;
  if (count == 3) {
    add_triple(places, 1.0 / 6.0, 1.0 / 6.0);
    return places;
  }
  places.push_back({{1.0 / 3.0, 1.0 / 3.0, 0.0}, count == 1 ? 0.5 : 9.0 / 80.0});
  if (count == 1) return places;
  const double root = std::sqrt(15.0);
  add_triple(places, (6.0 - root) / 21.0, (155.0 - root) / 2400.0);
  add_triple(places, (6.0 + root) / 21.0, (155.0 + root) / 2400.0);
  return places;
}

/// Four points near the corners (or, for b above a quarter, near the faces), each with three of its volume coordinates
/// equal to b.
void add_quadruple(Points& places, double b, double weight) {
  const double a = 1.0 - 3.0 * b;
  for (const auto& place : {Eigen::Vector3d(b, b, b), {a, b, b}, {b, a, b}, {b, b, a}})
    places.push_back({place, weight});
}

/// Points of degree 1, 2 or 5 on the tetrahedron.
Points tetrahedron_points(int count) {
  Points places;
  if (count == 4) {
    add_quadruple(places, (5.0 - std::sqrt(5.0)) / 20.0, 1.0 / 24.0);
    return places;
  }
  places.push_back({{0.25, 0.25, 0.25}, count == 1 ? 1.0 / 6.0 : 8.0 / 405.0});
  if (count == 1) return places;
  const double root = std::sqrt(15.0);
  add_quadruple(places, (7.0 - root) / 34.0, (2665.0 + 14.0 * root) / 226800.0);
  add_quadruple(places, (7.0 + root) / 34.0, (2665.0 - 14.0 * root) / 226800.0);
  const double a = (5.0 - root) / 20.0, b = (5.0 + root) / 20.0;
  for (const auto& place : {Eigen::Vector3d(a, b, b), {b, a, b}, {b, b, a}, {b, a, a}, {a, b, a}, {a, a, b}})
    places.push_back({place, 5.0 / 567.0});
  return places;
}

Points wedge_points(int in_triangle, int along) {
  Points places;
  for (const auto& [t, weight] : gauss(along))
    for (const auto& point : triangle_points(in_triangle))
      places.push_back({{point.place.x(), point.place.y(), t}, weight * point.weight});
  return places;
}

Points hexahedron_points(int along) {
  Points places;
  for (const auto& [t, weight_t] : gauss(along))
    for (const auto& [s, weight_s] : gauss(along))
      for (const auto& [r, weight_r] : gauss(along)) places.push_back({{r, s, t}, weight_r * weight_s * weight_t});
  return places;
}

Points corner_points(CellShape shape) {
  Points places;
  const auto nodes = natural_nodes(shape);
  for (int i = 0; i < corner_count(shape); ++i) places.push_back({nodes.col(i), 0.0});
  return places;
}

// Points by purpose: enough to integrate the strain energy of the undistorted shape exactly, fewer where reduced
// integration is asked for, and enough for N_i N_j of the mass, whose degree is twice that of the functions.
Points places_of(CellShape shape, RulePurpose purpose) {
  if (purpose == RulePurpose::corners) return corner_points(shape);
  const auto pick = [&](int strain, int reduced, int mass) {
    return purpose == RulePurpose::strain ? strain : purpose == RulePurpose::reduced_strain ? reduced : mass;
  };
  switch (shape) {
    case CellShape::tetrahedron4:
      return tetrahedron_points(pick(1, 1, 4));
    case CellShape::tetrahedron10:
      return tetrahedron_points(pick(4, 4, 15));
    case CellShape::wedge6:
      return wedge_points(pick(3, 1, 7), pick(2, 2, 3));
    case CellShape::wedge15:
      return wedge_points(pick(3, 3, 7), pick(3, 2, 4));
    case CellShape::hexahedron8:
      return hexahedron_points(pick(2, 1, 3));
    default:
      return hexahedron_points(pick(3, 2, 4));
  }
}

IntegrationRule make_rule(CellShape shape, RulePurpose purpose) {
  IntegrationRule rule;
  for (const auto& [place, weight] : places_of(shape, purpose))
    rule.push_back({place, weight, solid_shape_functions(shape, place)});
  return rule;
}

constexpr std::array solids = {CellShape::tetrahedron4, CellShape::tetrahedron10, CellShape::wedge6,
                               CellShape::wedge15,      CellShape::hexahedron8,   CellShape::hexahedron20};
constexpr std::array purposes = {RulePurpose::strain, RulePurpose::reduced_strain, RulePurpose::mass,
                                 RulePurpose::corners};

}  // namespace

const IntegrationRule& integration_rule(CellShape shape, RulePurpose purpose) {
  using Rules = std::array<IntegrationRule, purposes.size()>;
  static const auto all = [] {
    std::array<Rules, solids.size()> table;
    for (std::size_t i = 0; i < solids.size(); ++i)
      for (const auto use : purposes) table[i][static_cast<std::size_t>(use)] = make_rule(solids[i], use);
    return table;
  }();
  const auto place = std::ranges::find(solids, shape) - solids.begin();
  return all[static_cast<std::size_t>(place)][static_cast<std::size_t>(purpose)];
}

namespace {

/// A Jacobian smaller than this part of the box of its tangents is rounding.
constexpr double least_jacobian = 1e-10;

double relative_jacobian(const SolidPoint& point) {
  const double box = point.tangents.colwise().norm().prod();
  return box > 0.0 ? point.jacobian / box : 0.0;
}

void require_distinct_nodes(const SolidNodes& nodes) {
  const double extent = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  // Nearer than this, the distance is the rounding of the coordinates.
  const double nearest = std::max(1e-8 * extent, 1e-14 * nodes.cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < nodes.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (!((nodes.col(i) - nodes.col(j)).norm() > nearest))
        throw ElementShapeError("its nodes " + std::to_string(j + 1) + " and " + std::to_string(i + 1) + " coincide");
}

// Negative at all corners: the numbering is reversed, which the message says. At some corners it may be negative where
// the integration points, which are inside, are fine: solid_points() judges those.
void require_right_side_out(CellShape shape, const SolidNodes& nodes) {
  if (std::ranges::all_of(integration_rule(shape, RulePurpose::corners), [&](const IntegrationPoint& at) {
        return relative_jacobian(solid_tangents(at, nodes)) < -least_jacobian;
      }))
    throw ElementShapeError(
        "it is inside out (negative Jacobian): seen from its second face, the first face must be numbered "
        "counter-clockwise");
}

}  // namespace

SolidPoint solid_tangents(const IntegrationPoint& at, const SolidNodes& nodes) {
  SolidPoint point;
  point.place = at.place;
  point.tangents = nodes * at.functions.slopes;
  point.jacobian = point.tangents.determinant();
  point.volume = at.weight * point.jacobian;
  return point;
}

// The mapping at each point: tangents J = X dN/dr, their determinant for the volume, and dN/dx = dN/dr J^-1. A Jacobian
// is judged against the box of its tangents, so that the test does not depend on the size of the element.
std::vector<SolidPoint> solid_points(const IntegrationRule& rule, const SolidNodes& nodes) {
  std::vector<SolidPoint> points;
  points.reserve(rule.size());
  for (const auto& at : rule) {
    SolidPoint point = solid_tangents(at, nodes);
    if (!(relative_jacobian(point) > least_jacobian))
      throw ElementShapeError("it is flat, folded or crossed: at an integration point the Jacobian is not positive");
    point.gradients = at.functions.slopes * point.tangents.inverse();
    points.push_back(std::move(point));
  }
  return points;
}

StrainMatrix strain_matrix(const ShapeSlopes& gradients) {
  StrainMatrix strains = StrainMatrix::Zero(6, 3 * gradients.rows());
  for (Eigen::Index i = 0; i < gradients.rows(); ++i) {
    const double x = gradients(i, 0), y = gradients(i, 1), z = gradients(i, 2);
    strains.middleCols<3>(3 * i) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
  }
  return strains;
}

void require_sound(CellShape shape, const SolidNodes& nodes) {
  if (!nodes.allFinite()) throw ElementShapeError("a coordinate of its nodes is not a finite number");
  require_distinct_nodes(nodes);
  require_right_side_out(shape, nodes);
}

}  // namespace kalfem
