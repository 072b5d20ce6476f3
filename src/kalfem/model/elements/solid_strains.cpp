// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/solid_strains.hpp"

#include <Eigen/QR>

#include "kalfem/model/elements/enhanced_solid.hpp"

namespace kalfem {
namespace {

/// Strains at some natural places.
struct Samples {
  Eigen::Matrix3Xd places;
  SolidStrains strains;

  void add(const Eigen::Vector3d& place, const Eigen::VectorXd& strain) {
    places.conservativeResize(3, places.cols() + 1);
    strains.conservativeResize(6, strains.cols() + 1);
    places.rightCols<1>() = place;
    strains.rightCols<1>() = strain;
  }
};

Samples displacement_strains(const std::vector<SolidPoint>& points, const Eigen::VectorXd& displacements) {
  Samples samples;
  for (const auto& point : points) samples.add(point.place, strain_matrix(point.gradients) * displacements);
  return samples;
}

Samples with_enhanced_strains(CellShape shape, const SolidNodes& nodes, const Matrix6& elasticity,
                              const Eigen::VectorXd& displacements) {
  const auto points = enhanced_points(shape, nodes);
  const Eigen::VectorXd amounts = condense(points, elasticity).amounts * displacements;
  const auto& rule = integration_rule(shape, RulePurpose::strain);
  Samples samples;
  for (std::size_t i = 0; i < points.size(); ++i)
    samples.add(rule[i].place, points[i].strains * displacements + points[i].modes * amounts);
  return samples;
}

/// The volume change of every point is replaced by its mean over the element.
Samples mean_dilatation_strains(const std::vector<SolidPoint>& points, const Eigen::VectorXd& displacements) {
  Samples samples = displacement_strains(points, displacements);
  double change = 0.0, volume = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    change += points[i].volume * samples.strains.col(static_cast<Eigen::Index>(i)).head<3>().sum();
    volume += points[i].volume;
  }
  for (auto strain : samples.strains.colwise())
    strain.head<3>().array() += (change / volume - strain.head<3>().sum()) / 3.0;
  return samples;
}

/// The one strain of the hexahedron8 with a stabilised hourglass: the mean over the element.
Samples mean_strains(const std::vector<SolidPoint>& points, const Eigen::VectorXd& displacements) {
  const Samples all = displacement_strains(points, displacements);
  Eigen::VectorXd volumes(all.strains.cols());
  for (Eigen::Index i = 0; i < volumes.size(); ++i) volumes[i] = points[static_cast<std::size_t>(i)].volume;
  Samples samples;
  samples.add(Eigen::Vector3d::Zero(), all.strains * volumes / volumes.sum());
  return samples;
}

/// The same choice as that of the stiffness, see solid().
Samples sampled(CellShape shape, const SolidNodes& nodes, SolidKind kind, const Matrix6& elasticity,
                const Eigen::VectorXd& displacements) {
  const bool linear = shape == CellShape::hexahedron8 || shape == CellShape::wedge6;
  const auto points = [&](RulePurpose purpose) { return solid_points(integration_rule(shape, purpose), nodes); };
  if (kind == SolidKind::standard && linear) return with_enhanced_strains(shape, nodes, elasticity, displacements);
  if (kind == SolidKind::mean_dilatation && linear)
    return mean_dilatation_strains(points(RulePurpose::strain), displacements);
  if (kind == SolidKind::reduced && shape == CellShape::hexahedron8)
    return mean_strains(points(RulePurpose::strain), displacements);
  const bool few = kind == SolidKind::reduced || (kind == SolidKind::standard && shape == CellShape::hexahedron20);
  return displacement_strains(points(few ? RulePurpose::reduced_strain : RulePurpose::strain), displacements);
}

}  // namespace

CellShape linear_shape(CellShape shape) {
  switch (corner_count(shape)) {
    case 4:
      return CellShape::tetrahedron4;
    case 6:
      return CellShape::wedge6;
    default:
      return CellShape::hexahedron8;
  }
}

namespace {

/// Shape functions of the corners at natural places, places x corners.
Eigen::MatrixXd corner_functions(CellShape shape, const Eigen::Matrix3Xd& places) {
  Eigen::MatrixXd functions(places.cols(), corner_count(shape));
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    functions.row(i) = solid_shape_functions(linear_shape(shape), places.col(i)).values;
  return functions;
}

/// Natural places of the nodes and of the centre.
Eigen::Matrix3Xd wanted_places(CellShape shape) {
  Eigen::Matrix3Xd places(3, node_count(shape) + 1);
  places.leftCols(node_count(shape)) = natural_nodes(shape);
  places.rightCols<1>() = natural_nodes(shape).leftCols(corner_count(shape)).rowwise().mean();
  return places;
}

}  // namespace

SolidStrains solid_strains(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                           double poissons_ratio, const Eigen::VectorXd& displacements) {
  require_sound(shape, nodes);
  const SolidNodes centred = nodes.colwise() - nodes.rowwise().mean();
  const Matrix6 elasticity = property.elasticity.value_or(isotropic_elasticity(poissons_ratio));
  const Samples samples = sampled(shape, centred, property.kind, elasticity, displacements);
  const Eigen::MatrixXd corners = corner_functions(shape, samples.places)
                                      .completeOrthogonalDecomposition()
                                      .solve(Eigen::MatrixXd(samples.strains.transpose()));
  return (corner_functions(shape, wanted_places(shape)) * corners).transpose();
}

}  // namespace kalfem
