#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// A part R^T M R of the structure's mass in the motions R of a rigid body about the origin: translations along x, y, z
/// [m/m] and rotations about them [m/rad]. It counts every node, held or not.
struct RigidMass {
  std::map<std::string, int> powers;  ///< of parameters, as those of an AffineTerm
  Matrix6 matrix = Matrix6::Zero();   ///< per unit of them [kg, kg m, kg m^2]
};

/// Sums up the mass of elements, point masses and matrices before supports and links take degrees of freedom away.
class RigidMassSum {
public:
  using Powers = std::map<std::string, int>;

  explicit RigidMassSum(const Mesh& mesh);

  /// R^T M R of a small mass matrix over the first `motions` degrees of freedom of each of the nodes.
  [[nodiscard]] Matrix6 of(std::span<const Eigen::Index> nodes, int motions, const Eigen::MatrixXd& mass) const;
  /// The same of a matrix over degrees of freedom; those of scalar points do not move with a rigid body.
  [[nodiscard]] Matrix6 of(const std::vector<NodalDof>& dofs, const Eigen::SparseMatrix<double>& mass) const;

  void add(const Powers& powers, const Matrix6& part) {
    sums_.try_emplace(powers, Matrix6::Zero()).first->second += part;
  }
  [[nodiscard]] std::vector<RigidMass> list() const;

private:
  const Mesh& mesh_;
  std::vector<bool> is_scalar_;  ///< by node
  std::map<Powers, Matrix6> sums_;
};

}  // namespace kalfem
