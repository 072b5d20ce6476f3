// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/reduction/partition.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Fixed-interface modes of the interior that a selection keeps, and why.
struct SelectedModes {
  LowestModes modes;
  Eigen::Index rigid = 0;  ///< how many of them are rigid-body modes
  std::string reason;
};

/// The interior's rigid-body modes while the boundary is held, n_i x r; none where K_ii is positive definite.
Eigen::MatrixXd rigid_body_modes(const Partition& parts, const StiffnessFactor& factored);

/// `following`: motion of the interior with each translation of the boundary, n_i x directions; effective mass alone
/// needs it. Rigid-body modes are kept in any case. Throws InvalidInput where no criterion is given, or a value is out
/// of its range.
SelectedModes select_modes(const Partition& parts, const Eigen::MatrixXd& following, const StiffnessFactor& factored,
                           const ModeSelection& selection);

/// Unit displacements of the boundary in each translation, n_b x directions; the names' last part tells the direction.
Eigen::MatrixXd translations(const std::vector<std::string>& boundary_names);

}  // namespace kalfem
