// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "kalfem/model/assembly/held_motions.hpp"

namespace kalfem {

/// The surface that the shells form at a node.
struct NodalSurface {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< sum over the cells, by area; zero where there is no shell
  double shear_stiffness = 0.0;  ///< sum of G t |J|, |J| = A / 4 of a quadrilateral, 2 A of a triangle
  bool is_smooth = true;         ///< the normals of all cells lie within 20 degrees of their mean

  [[nodiscard]] bool is_surface() const { return is_smooth && normal.norm() > 0.0; }
};

/// Calls visit(cell, normal times area, G t) for each shell.
using ShellVisitor = std::function<void(const Cell&, const Eigen::Vector3d&, double)>;
void for_each_shell(const FiniteElementModel& model, const ShellVisitor& visit);

/// Of every node.
std::vector<NodalSurface> nodal_surfaces(const FiniteElementModel& model);

/// Nodes whose rotations something else than shells acts on: beams, springs, links, constraints with other nodes,
/// matrices.
std::vector<bool> turned_by_others(const FiniteElementModel& model);

/// Whether a held translation of a node has a part in the plane of its surface.
bool is_held_in_plane(const HeldMotions& held, Eigen::Index node, const NodalSurface& surface);

/// Rotations that supports hold and that have a part about the normal of a smooth surface, at nodes that nothing holds
/// in the plane of the surface; by node and then direction.
std::vector<NodalDof> held_drilling(const FiniteElementModel& model, const std::vector<NodalSurface>& surfaces);

/// Whether the rotation turns about the normal of its node and about nothing else.
bool is_along_normal(const std::vector<NodalSurface>& surfaces, const NodalDof& dof);

/// Takes degrees of freedom out of the supports. `dofs`: by node and then direction.
void release(FiniteElementModel& model, const std::vector<NodalDof>& dofs);

}  // namespace kalfem
