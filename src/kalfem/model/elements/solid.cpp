// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/solid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/elements/enhanced_solid.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double stabilising_share = 0.02;

/// Stress per strain of a material with this modulus for every strain: half of it per engineering shear.
Matrix6 even_elasticity(double modulus) {
  return (Vector6() << modulus, modulus, modulus, 0.5 * modulus, 0.5 * modulus, 0.5 * modulus).finished().asDiagonal();
}

/// Least eigenvalue of stress per strain, as tensors.
double softest_modulus(const Matrix6& elasticity) {
  const double root = std::sqrt(2.0);
  const auto scale = (Vector6() << 1.0, 1.0, 1.0, root, root, root).finished();
  const Matrix6 tensor = scale.asDiagonal() * elasticity * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(tensor, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// du/dx + dv/dy + dw/dz per nodal motion.
Eigen::RowVectorXd dilatation(const StrainMatrix& strains) { return strains.topRows<3>().colwise().sum(); }

/// Stiffness of the interpolated displacements, K = sum_p B_p^T D B_p V_p over the points.
Eigen::MatrixXd displacement_stiffness(const std::vector<SolidPoint>& points, const Matrix6& elasticity) {
  const Eigen::Index size = 3 * points.front().gradients.rows();
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  for (const auto& point : points) {
    const StrainMatrix strains = strain_matrix(point.gradients);
    stiffness.noalias() += strains.transpose() * (point.volume * elasticity * strains);
  }
  return stiffness;
}

/// The same with the volume change of every point replaced by its mean over the element (B-bar [Hug80]).
Eigen::MatrixXd mean_dilatation_stiffness(const std::vector<SolidPoint>& points, const Matrix6& elasticity) {
  const Eigen::Index size = 3 * points.front().gradients.rows();
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(size);
  double volume = 0.0;
  for (const auto& point : points) {
    mean += point.volume * dilatation(strain_matrix(point.gradients));
    volume += point.volume;
  }
  mean /= volume;
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  for (const auto& point : points) {
    StrainMatrix strains = strain_matrix(point.gradients);
    const Eigen::RowVectorXd correction = (mean - dilatation(strains)) / 3.0;
    strains.topRows<3>().rowwise() += correction;
    stiffness.noalias() += strains.transpose() * (point.volume * elasticity * strains);
  }
  return stiffness;
}

/// Stiffness of fewer points, in which a small part of the elasticity is integrated with all of them,
///     K = sum_few B^T (D - d m I) B V + sum_all B^T (d m I) B V,
/// m the softest modulus of D (least eigenvalue of stress per strain; 2 G of common isotropic materials), d = 0.02. The
/// six motions of a hexahedron20 that eight points do not see get 0.02 of the stiffness that they would have: in a free
/// element frequencies of a fifth of its first elastic one. The locking of all the points comes back by that part only,
/// and that of volume not at all.
Eigen::MatrixXd stabilised_stiffness(const std::vector<SolidPoint>& few, const std::vector<SolidPoint>& all,
                                     const Matrix6& elasticity) {
  const Matrix6 part = even_elasticity(stabilising_share * softest_modulus(elasticity));
  return displacement_stiffness(few, elasticity - part) + displacement_stiffness(all, part);
}

/// Hourglass functions st, rt, rs and rst by their slopes along r, s, t at a place.
Eigen::Matrix<double, 4, 3> hourglass_slopes(const Eigen::Vector3d& place) {
  const double r = place[0], s = place[1], t = place[2];
  return (Eigen::Matrix<double, 4, 3>() << 0, t, s, t, 0, r, s, r, 0, s * t, r * t, r * s).finished();
}

/// Stiffness of hourglass motions q_a of unit size along x, y, z, on the parallelepiped with these tangents.
Eigen::MatrixXd hourglass_stiffness(const Eigen::Matrix3d& tangents, const Matrix6& elasticity) {
  const double jacobian = tangents.determinant();
  std::vector<EnhancedPoint> points;
  for (const auto& at : integration_rule(CellShape::hexahedron8, RulePurpose::strain))
    points.push_back({strain_matrix(hourglass_slopes(at.place) * tangents.inverse()),
                      enhanced_strains(CellShape::hexahedron8, at.place, tangents, jacobian), at.weight * jacobian});
  return condense(points, elasticity).stiffness;
}

/// gamma_a at the nodes, 8 x 4: no part of a motion that is linear in space.
Eigen::Matrix<double, 8, 4> hourglass_patterns(const SolidNodes& nodes, const ShapeSlopes& mean_gradients) {
  const SolidNodes corners = natural_nodes(CellShape::hexahedron8);
  Eigen::Matrix<double, 8, 4> patterns;
  for (int i = 0; i < 8; ++i) {
    const double r = corners(0, i), s = corners(1, i), t = corners(2, i);
    patterns.row(i) << s * t, r * t, r * s, r * s * t;
  }
  return 0.125 * (patterns - mean_gradients * (nodes * patterns));
}

/// Stiffness of a hexahedron8 of the mean strains [FB81] and of its twelve hourglass motions,
///     K = V B^T D B + Gamma^T K_h Gamma,  gamma_a = 1/8 (h_a - sum_i (h_a . x_i) b_i),
/// b_i the mean gradients of the shape functions. K_h is the stiffness of the hourglass functions st, rt, rs and rst
/// with the enhanced strains of enhanced_points(), on the parallelepiped with the tangents of the centre (in the
/// manner of [Pus00]): no parameter, no locking, and equal to enhanced_points() on a parallelepiped.
Eigen::MatrixXd one_point_hexahedron_stiffness(const SolidNodes& nodes, const Matrix6& elasticity) {
  ShapeSlopes gradients = ShapeSlopes::Zero(8, 3);
  double volume = 0.0;
  for (const auto& point : solid_points(integration_rule(CellShape::hexahedron8, RulePurpose::strain), nodes)) {
    gradients += point.volume * point.gradients;
    volume += point.volume;
  }
  gradients /= volume;
  const StrainMatrix strains = strain_matrix(gradients);
  const auto patterns = hourglass_patterns(nodes, gradients);
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(12, 24);  // Gamma
  for (int i = 0; i < 8; ++i)
    for (int a = 0; a < 4; ++a) motions.block<3, 3>(3 * a, 3 * i).diagonal().setConstant(patterns(i, a));
  const auto centre = centre_tangents(CellShape::hexahedron8, nodes);
  return strains.transpose() * (volume * elasticity * strains) +
         motions.transpose() * hourglass_stiffness(centre, elasticity) * motions;
}

Eigen::MatrixXd stiffness_of(CellShape shape, const SolidNodes& nodes, SolidKind kind, const Matrix6& elasticity) {
  const bool linear = shape == CellShape::hexahedron8 || shape == CellShape::wedge6;
  const auto points = [&](RulePurpose purpose) { return solid_points(integration_rule(shape, purpose), nodes); };
  switch (kind) {
    case SolidKind::standard:
      if (linear) return condense(enhanced_points(shape, nodes), elasticity).stiffness;
      if (shape == CellShape::hexahedron20)
        return stabilised_stiffness(points(RulePurpose::reduced_strain), points(RulePurpose::strain), elasticity);
      break;
    case SolidKind::mean_dilatation:
      if (linear) return mean_dilatation_stiffness(points(RulePurpose::strain), elasticity);
      break;
    case SolidKind::reduced:
      if (shape == CellShape::hexahedron8) return one_point_hexahedron_stiffness(nodes, elasticity);
      return displacement_stiffness(points(RulePurpose::reduced_strain), elasticity);
    case SolidKind::full:
      break;
  }
  return displacement_stiffness(points(RulePurpose::strain), elasticity);
}

/// int N_i N_j dV, nodes x nodes. Lumped: its diagonal, scaled to the volume.
Eigen::MatrixXd mass_shares(CellShape shape, const SolidNodes& nodes, MassKind kind) {
  const auto& rule = integration_rule(shape, RulePurpose::mass);
  const auto points = solid_points(rule, nodes);
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(nodes.cols(), nodes.cols());
  double volume = 0.0;
  for (std::size_t i = 0; i < rule.size(); ++i) {
    const auto& values = rule[i].functions.values;
    shares.noalias() += points[i].volume * values * values.transpose();
    volume += points[i].volume;
  }
  if (kind == MassKind::consistent) return 0.5 * (shares + shares.transpose());
  return (volume / shares.trace()) * Eigen::MatrixXd(shares.diagonal().asDiagonal());
}

/// The same for the motions x, y and z of each node.
Eigen::MatrixXd in_three_directions(const Eigen::MatrixXd& shares) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * shares.rows(), 3 * shares.cols());
  for (Eigen::Index i = 0; i < shares.rows(); ++i)
    for (Eigen::Index j = 0; j < shares.cols(); ++j) all.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(shares(i, j));
  return all;
}

/// The given elasticity. Throws InvalidInput where it is none.
Matrix6 checked(const Matrix6& elasticity) {
  const double size = elasticity.cwiseAbs().maxCoeff();
  if (!elasticity.allFinite() || !((elasticity - elasticity.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * size) ||
      elasticity.llt().info() != Eigen::Success)
    throw InvalidInput("the elasticity of a solid is not symmetric and positive definite",
                       "every strain must have positive energy", "correct the moduli and Poisson's ratios");
  return 0.5 * (elasticity + elasticity.transpose());
}

}  // namespace

Matrix6 isotropic_elasticity(double poissons_ratio) {
  const double shear = 1.0 / (1.0 + poissons_ratio);  // 2 mu
  Matrix6 elasticity = even_elasticity(shear);
  elasticity.topLeftCorner<3, 3>().array() += shear * poissons_ratio / (1.0 - 2.0 * poissons_ratio);
  return elasticity;
}

ElementMatrices solid(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                      double poissons_ratio, MassKind mass_kind) {
  if (dimension(shape) != 3) throw ElementShapeError("a " + to_string(shape) + " is not a solid element");
  if (nodes.cols() != node_count(shape))
    throw ElementShapeError("a " + to_string(shape) + " has " + std::to_string(node_count(shape)) + " nodes, not " +
                            std::to_string(nodes.cols()));
  require_sound(shape, nodes);
  const SolidNodes centred = nodes.colwise() - nodes.rowwise().mean();  // a model far from the origin loses no digits
  const Matrix6 elasticity = property.elasticity ? checked(*property.elasticity) : isotropic_elasticity(poissons_ratio);
  const Eigen::MatrixXd stiffness = stiffness_of(shape, centred, property.kind, elasticity);
  return {{{{.youngs_modulus = property.elasticity ? 0 : 1}, 0.5 * (stiffness + stiffness.transpose())}},
          {{{.density = 1}, in_three_directions(mass_shares(shape, centred, mass_kind))}}};
}

}  // namespace kalfem
