// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Degrees of freedom of a model split into boundary and interior, with the blocks that a reduction needs.
struct Partition {
  std::vector<Eigen::Index> boundary;  ///< in the order given
  std::vector<Eigen::Index> interior;  ///< ascending
  std::vector<std::string> interior_names;
  SparseMatrix stiffness_ii, mass_ii, stiffness_ib;
};

/// Throws InvalidInput with every name that the model does not have, or that is given twice.
Partition partition(const LinearModel& model, const std::vector<std::string>& boundary);

}  // namespace kalfem
