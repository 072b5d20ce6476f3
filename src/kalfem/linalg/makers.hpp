// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "kalfem/linalg/factor_workspace.hpp"
#include "kalfem/linalg/long_vectors.hpp"

namespace kalfem {

/// Make the objects that hold most of a large problem's memory. They may answer nothing, or be empty: CHOLMOD then
/// factors, and vectors are in the memory of this process.
struct Makers {
  /// Factors matrices of a pattern, which it analyses; the order may be empty.
  std::function<std::unique_ptr<FactorWorkspace>(const UpperTriangle&, const EliminationOrder&)> factor = {};
  /// Vectors of so many rows.
  std::function<std::unique_ptr<LongVectors>(Eigen::Index)> long_vectors = {};
};

/// From now on `makers` are asked first, in the whole process; at the start they are empty. To be called while no other
/// thread factors. Returns the ones before.
Makers use_makers(Makers makers);

[[nodiscard]] const Makers& makers_in_use();

}  // namespace kalfem
