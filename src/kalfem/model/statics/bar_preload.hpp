// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Geometric stiffness of the springs that are bars, under the displacements [m] and rotations [rad] of all nodes: with
/// the axial force N = k d of the deformation d, the length L and the unit vector t along a bar,
///     K_g = N / L [I - t t^T, -(I - t t^T); -(I - t t^T), I - t t^T]   on the displacements of its two nodes [ZTZ05],
/// at all degrees of freedom, 6 to a node.
SparseMatrix bar_preload_stiffness(const FiniteElementModel& model, const Eigen::VectorXd& displacements);

/// Names of the springs and matrices between nodes at different places that carry a force under the displacements and
/// are no bars: they act along directions that do not turn with the nodes, so that their force stiffens nothing. Forces
/// below 1e-9 of the largest in springs and matrices count as none.
std::vector<std::string> springs_without_preload(const FiniteElementModel& model, const Eigen::VectorXd& displacements);

}  // namespace kalfem
