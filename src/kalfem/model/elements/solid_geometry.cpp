#include "kalfem/model/elements/solid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <string>

#include "kalfem/model/elements/element.hpp"

namespace kalfem {
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

void require_right_side_out(CellShape shape, const SolidNodes& nodes) {
  const auto& corners = integration_rule(shape, RulePurpose::corners);
  const auto negative = [&](const IntegrationPoint& at) {
    return relative_jacobian(solid_tangents(at, nodes)) < -least_jacobian;
  };
  if (std::ranges::all_of(corners, negative))
    throw ElementShapeError(
        "it is inside out (negative Jacobian): seen from its second face, the first face must be numbered "
        "counter-clockwise");
  if (node_count(shape) != corner_count(shape)) return;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (negative(corners[i]))
      throw ElementShapeError("it is folded: at corner " + std::to_string(i + 1) + " the Jacobian is negative");
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
