#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/system/coupling.hpp"

namespace kalfem {

/// What a sensor sees before its measurement chain.
enum class ObservedQuantity {
  displacement,
  velocity,
  acceleration,
  connector_force,
  connector_deformation,
  connector_rate
};

/// SI unit of a quantity.
std::string unit_of(ObservedQuantity quantity);

/// A few rows over many degrees of freedom.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// One observed quantity: at a point (absolute, or relative to the base) or in a connector.
struct OutputDescription {
  std::string name;
  ObservedQuantity quantity = ObservedQuantity::acceleration;
  DofCombination points;          ///< sum of coefficient times quantity, by qualified point or by connector
  bool relative_to_base = false;  ///< with base_acceleration inputs: leave the base's own motion out
};

/// y = S_d z + S_v z' + S_a z'' + T_d r + T_v r' + T_a r'' + F f.
struct OutputMap {
  std::vector<std::string> names;
  std::vector<std::string> units;
  SparseRows displacement, velocity, acceleration;              ///< l x n
  Eigen::MatrixXd input_value, input_rate, input_acceleration;  ///< l x n_u
  Eigen::MatrixXd force;                                        ///< l x m

  [[nodiscard]] Eigen::Index size() const { return displacement.rows(); }
};

/// Throws InvalidInput with every output whose point or connector does not exist.
OutputMap make_outputs(const CoupledModel& model, const std::vector<OutputDescription>& descriptions);

}  // namespace kalfem
