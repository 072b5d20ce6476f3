// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/assembly/assembly.hpp"
#include "model/fe_models.hpp"

namespace kalfem::test {

/// Places of a beam's two ends [m].
using Ends = Eigen::Matrix<double, 3, 2>;

/// A section without shear.
inline BeamSection slender(BeamSection section = rectangular_section(0.02, 0.03)) {
  section.shear_factor_y = section.shear_factor_z = 0.0;
  return section;
}

/// Motion of the last node of beams that are clamped at the first, under a load at the last.
inline Eigen::Matrix<double, 6, 1> tip_motion(FiniteElementModel model, const Eigen::Matrix<double, 6, 1>& load) {
  model.fixed = {{.name = "clamp", .nodes = {0}}};
  const auto assembled = assemble(model);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(assembled.size());
  force.tail(6) = load;
  return stiffness_of(assembled).ldlt().solve(force).tail(6);
}

}  // namespace kalfem::test
