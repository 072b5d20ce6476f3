#include "kalfem/model/elements/solid_stiffness.hpp"

#include <cmath>

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

}  // namespace

Matrix6 isotropic_elasticity(double poissons_ratio) {
  const double shear = 1.0 / (1.0 + poissons_ratio);  // 2 mu
  Matrix6 elasticity = even_elasticity(shear);
  elasticity.topLeftCorner<3, 3>().array() += shear * poissons_ratio / (1.0 - 2.0 * poissons_ratio);
  return elasticity;
}

Eigen::MatrixXd displacement_stiffness(const std::vector<SolidPoint>& points, const Matrix6& elasticity) {
  const Eigen::Index size = 3 * points.front().gradients.rows();
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  for (const auto& point : points) {
    const StrainMatrix strains = strain_matrix(point.gradients);
    stiffness.noalias() += strains.transpose() * (point.volume * elasticity * strains);
  }
  return stiffness;
}

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

Eigen::MatrixXd stabilised_stiffness(const std::vector<SolidPoint>& few, const std::vector<SolidPoint>& all,
                                     const Matrix6& elasticity) {
  const Matrix6 part = even_elasticity(stabilising_share * softest_modulus(elasticity));
  return displacement_stiffness(few, elasticity - part) + displacement_stiffness(all, part);
}

}  // namespace kalfem
