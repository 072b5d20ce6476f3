#include "kalfem/model/elements/solid.hpp"

#include <Eigen/Cholesky>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/elements/solid_enhanced.hpp"
#include "kalfem/model/elements/solid_stiffness.hpp"

namespace kalfem {
namespace {

Eigen::MatrixXd stiffness_of(CellShape shape, const SolidNodes& nodes, SolidKind kind, const Matrix6& elasticity) {
  const bool linear = shape == CellShape::hexahedron8 || shape == CellShape::wedge6;
  const auto points = [&](RulePurpose purpose) { return solid_points(integration_rule(shape, purpose), nodes); };
  switch (kind) {
    case SolidKind::standard:
      if (linear) return enhanced_stiffness(shape, nodes, elasticity);
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
                       "every strain must need energy", "give other moduli and Poisson's ratios");
  return 0.5 * (elasticity + elasticity.transpose());
}

}  // namespace

ElementMatrices solid(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                      double poissons_ratio, MassKind mass_kind) {
  if (dimension(shape) != 3) throw ElementShapeError("a " + to_string(shape) + " is no solid");
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
