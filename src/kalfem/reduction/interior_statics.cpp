// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/interior_statics.hpp"

#include <algorithm>

#include "kalfem/linalg/long_products.hpp"
#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The loads on a free body that its displacements answer are in equilibrium, so springs at a statically determinate
// support carry nothing, whatever their stiffness: the solution is that of the free body.
InteriorStatics::InteriorStatics(const Partition& parts, const StiffnessFactor& factored, const MatrixXd& rigid_modes)
    : parts_(parts), factored_(factored), rigid_modes_(rigid_modes) {
  if (!factored.regular())
    supported_.emplace(parts.stiffness_ii, EliminationOrder(), supports(parts.stiffness_ii, rigid_modes));
}

MatrixXd InteriorStatics::response(MatrixXd loads) const {
  if (!supported_) {
    factored_.factor.solve(loads, loads);
    return loads;
  }
  MatrixXd displacements = supported_->solve(loads);
  // What the factor of a nearly singular matrix lost in the first place.
  displacements += supported_->solve(loads - parts_.stiffness_ii * displacements);
  return displacements - rigid_modes_ * (rigid_modes_.transpose() * (parts_.mass_ii * displacements));
}

std::unique_ptr<LongVectors> InteriorStatics::constraint_modes() const {
  const Index count = parts_.stiffness_ib.cols();
  auto modes = make_long_vectors(parts_.stiffness_ii.rows());
  modes->reserve(count);
  by_panels(count, widest_panel, [&](Index first, Index width) {
    modes->put(first, response(-parts_.stiffness_ib.middleCols(first, width)));
  });
  return modes;
}

double static_error(const Partition& parts, const LongVectors& constraint_modes) {
  double largest = 0.0;
  visit_products(parts.stiffness_ii, constraint_modes, constraint_modes.capacity(),
                 [&](Index first, const TallMatrix&, const TallMatrix& forces) {
                   for (Index j = 0; j < forces.cols(); ++j)
                     if (const VectorXd load = parts.stiffness_ib.col(first + j); load.norm() > 0.0)
                       largest = std::max(largest, (forces.col(j) + load).norm() / load.norm());
                 });
  return largest;
}

}  // namespace kalfem
