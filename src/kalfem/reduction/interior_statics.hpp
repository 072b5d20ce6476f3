// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "kalfem/linalg/long_vectors.hpp"
#include "kalfem/linalg/stiffness_factor.hpp"
#include "kalfem/reduction/partition.hpp"

namespace kalfem {

/// U with K_ii U = F: how the interior follows static loads F, n_i x k, while the boundary is held. Where K_ii was
/// shifted because it may be singular, F must be in equilibrium (R^T F = 0 with the M_ii-normalised rigid-body modes R,
/// n_i x r, r may be 0), and R^T M_ii U = 0 holds.
class InteriorStatics {
public:
  /// Everything is kept by reference.
  InteriorStatics(const Partition& parts, const StiffnessFactor& factored, const Eigen::MatrixXd& rigid_modes);

  [[nodiscard]] Eigen::MatrixXd response(Eigen::MatrixXd loads) const;

  /// Psi with K_ii Psi = -K_ib, n_i x n_b: how the interior follows unit displacements of the boundary statically.
  [[nodiscard]] std::unique_ptr<LongVectors> constraint_modes() const;

private:
  const Partition& parts_;
  const StiffnessFactor& factored_;
  const Eigen::MatrixXd& rigid_modes_;
  std::optional<SparseFactor> supported_;  ///< of K_ii held statically determinate, where it was shifted
};

/// Largest |K_ii psi + K_ib| / |K_ib| over the columns.
double static_error(const Partition& parts, const LongVectors& constraint_modes);

}  // namespace kalfem
