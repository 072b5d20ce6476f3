// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/system/coupling.hpp"
#include "kalfem/system/sensors/output_description.hpp"

namespace kalfem {

/// A few rows over many degrees of freedom.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

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
