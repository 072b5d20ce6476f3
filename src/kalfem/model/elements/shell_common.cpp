#include "kalfem/model/elements/shell_common.hpp"

#include <algorithm>

namespace kalfem {

double relative_shear_modulus(double poissons_ratio) { return 0.5 / (1.0 + poissons_ratio); }

Eigen::Matrix3d plane_stress(double poissons_ratio) {
  const double nu = poissons_ratio;
  const Eigen::Matrix3d stiffness{{1.0, nu, 0.0}, {nu, 1.0, 0.0}, {0.0, 0.0, (1.0 - nu) / 2.0}};
  return stiffness / (1.0 - nu * nu);
}

void require_distinct(const Eigen::Matrix3Xd& corners) {
  if (!corners.allFinite()) throw ElementShapeError("a coordinate of its nodes is not a finite number");
  const double extent = (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).norm();
  // Nearer than this, the distance is the rounding of the coordinates.
  const double nearest = std::max(1e-8 * extent, 1e-14 * corners.cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < corners.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (!((corners.col(i) - corners.col(j)).norm() > nearest))
        throw ElementShapeError("its corners " + std::to_string(j + 1) + " and " + std::to_string(i + 1) + " coincide");
}

std::vector<ElementTerm> plate_mass(const Eigen::MatrixXd& shares, MassKind mass_kind) {
  const Eigen::Index nodes = shares.rows();
  const Eigen::MatrixXd masses = mass_kind == MassKind::consistent
                                     ? Eigen::MatrixXd(0.5 * (shares + shares.transpose()))
                                     : Eigen::MatrixXd(shares.rowwise().sum().asDiagonal());
  Eigen::MatrixXd translation = Eigen::MatrixXd::Zero(6 * nodes, 6 * nodes), rotation = translation;
  for (Eigen::Index i = 0; i < nodes; ++i)
    for (Eigen::Index j = 0; j < nodes; ++j) {
      translation.block<3, 3>(6 * i, 6 * j).diagonal().setConstant(masses(i, j));
      rotation.block<3, 3>(6 * i + 3, 6 * j + 3).diagonal().setConstant(masses(i, j) / 12.0);
    }
  return {{{.density = 1, .thickness = 1}, std::move(translation)},
          {{.density = 1, .thickness = 3}, std::move(rotation)}};
}

}  // namespace kalfem
