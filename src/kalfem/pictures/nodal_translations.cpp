// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/nodal_translations.hpp"

namespace kalfem {

Eigen::Matrix3Xd nodal_translations(const FiniteElementPart& part, const Eigen::VectorXd& displacement) {
  const Eigen::VectorXd all = part.assembled.expansion * displacement;
  return all.reshaped(6, part.elements.mesh.node_count()).topRows(3);
}

}  // namespace kalfem
