#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <map>
#include <string>
#include <vector>

namespace kalfem {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Coefficients over the degrees of freedom of a model: a point's displacement is sum_i coefficient_i z_i.
using DofCombination = std::map<std::string, double>;

/// A linear spring-dashpot between a degree of freedom combination and a named moving ground.
struct GroundCoupling {
  std::string ground;
  Eigen::VectorXd stiffness;  ///< force on the model per ground displacement [N/m], n
  Eigen::VectorXd damping;    ///< force on the model per ground velocity [N s/m], n
};

/// M z'' + C z' + K z = sum_g (k_g r_g + c_g r_g'), a linear substructure with named degrees of freedom.
struct LinearModel {
  std::vector<std::string> dofs;
  SparseMatrix mass;       ///< [kg], n x n, symmetric
  SparseMatrix damping;    ///< [N s/m], n x n, symmetric
  SparseMatrix stiffness;  ///< [N/m], n x n, symmetric
  std::vector<GroundCoupling> grounds;
  std::map<std::string, DofCombination> points;  ///< named combinations beside the degrees of freedom themselves

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(dofs.size()); }
};

/// Undamped free vibration K phi = omega^2 M phi with phi^T M phi = 1.
struct NormalModes {
  Eigen::VectorXd frequencies;  ///< [Hz], ascending; rigid-body modes are 0
  Eigen::MatrixXd shapes;       ///< n x modes, mass-normalised
};

/// All modes of a model of moderate size by the dense generalised eigenproblem.
/// Throws InvalidInput where the mass matrix is not positive definite.
NormalModes normal_modes(const SparseMatrix& mass, const SparseMatrix& stiffness);

/// C = M Phi diag(2 zeta_i omega_i) Phi^T M for the given ratios, one a mode (the last one holds for all further
/// modes).
SparseMatrix modal_damping(const SparseMatrix& mass, const NormalModes& modes, const std::vector<double>& ratios);

}  // namespace kalfem
