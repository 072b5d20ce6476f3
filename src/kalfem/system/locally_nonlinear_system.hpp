// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"
#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// A local nonlinear element between two points, d = b^T z - g^T r.
struct Connector {
  std::string name;
  ConnectorLawPtr law;
  Eigen::VectorXd parameters;   ///< one value per law parameter
  Eigen::VectorXd deformation;  ///< b, deformation per displacement, n
  Eigen::VectorXd base;         ///< g, deformation lost per input value, n_u
};

/// One scalar input r(t) with its rate and acceleration.
struct Input {
  std::string name;
  std::string unit;       ///< of the value: m for a base displacement, N for a force, m/s^2 for a base acceleration
  Eigen::VectorXd value;  ///< force on the system per value, n
  Eigen::VectorXd rate;   ///< force per rate, n
  Eigen::VectorXd acceleration;  ///< force per second derivative, n
};

/// The one form that every system here has, full-order or reduced:
///     M z'' + (C + C_m) z' + K z + sum_j b_j f_j(d_j, d_j', d_j'', s_j; theta_j) = sum_i (p_i r_i + q_i r_i' + t_i
///     r_i''), d_j = b_j^T z - g_j^T r.
/// n degrees of freedom but only m << n connectors: every solver exploits it. Immutable after assembly.
struct LocallyNonlinearSystem {
  std::vector<std::string> dofs;  ///< "substructure.dof"
  SparseMatrix mass;              ///< [kg], n x n
  SparseMatrix damping;           ///< [N s/m], n x n, without C_m
  SparseMatrix stiffness;         ///< [N/m], n x n
  ModalDamping modal_damping;     ///< C_m of low rank; empty where there is none
  std::vector<Connector> connectors;
  std::vector<Input> inputs;

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(dofs.size()); }
  [[nodiscard]] Eigen::Index connector_count() const { return static_cast<Eigen::Index>(connectors.size()); }
  [[nodiscard]] Eigen::Index input_count() const { return static_cast<Eigen::Index>(inputs.size()); }
  /// C + C_m as a dense matrix, for systems of moderate size.
  [[nodiscard]] Eigen::MatrixXd full_damping() const;
  /// Sum of the connectors' internal states.
  [[nodiscard]] Eigen::Index connector_states() const;
  /// B = [b_1 ... b_m], n x m.
  [[nodiscard]] Eigen::MatrixXd connector_directions() const;
  /// g as rows, m x n_u.
  [[nodiscard]] Eigen::MatrixXd connector_bases() const;
};

}  // namespace kalfem
