// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// Translations of all nodes of a part, 3 x nodes [m], from its free degrees of freedom.
Eigen::Matrix3Xd nodal_translations(const FiniteElementPart& part, const Eigen::VectorXd& displacement);

}  // namespace kalfem
