// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unordered_map>
#include <vector>

#include "kalfem/model/elements/shell.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Share of a degree of freedom in a motion of a shell's corner.
struct EdgeShare {
  int row = 0;           ///< among the motions [x y z rx ry rz] of the corners in turn
  Eigen::Index dof = 0;  ///< position among all, 6 to a node
  double share = 0.0;
};

/// The drilling rotations of shells at the edges of their surface, and where supports hold them.
///
/// **Edges.** A side of a triangle bulges with the drilling rotations of its ends. The normal force s per length along
/// it then has the moments -b s and b s about these, b = bulge(), which cancel between the two triangles of a side. At
/// the edge of a surface nothing cancels them, and nodal forces have no moments: forces of a constant stress would not
/// be in equilibrium with it. So the displacement of a node i at an edge is taken for the mean one of the edge beside
/// it, that on which its force works: the triangles' corner there has
///     u_i - sum over the edge's sides e at i of g_ei b_e (theta_e2 - theta_e1) n_e,
/// with the sides' normals n_e in the surface, outwards, and the drilling rotations of their ends e1, e2. Under a
/// constant stress the force at i is stress . m_i, m_i = sum l_e n_e / 2; g follows from n_e = g_e1 m_e1 + g_e2 m_e2.
/// Nodal forces of constant stress are then in equilibrium with it on any mesh, and edges without forces bulge as
/// before. A side stays straight where it meets a quadrilateral of the same surface, whose sides do not bulge; where an
/// end follows, see below; and at an edge where no g of moderate size exists.
///
/// At the edges of curved surfaces m_i is projected onto the plane of the side's triangle, where g solves the equation
/// by least squares. A cylinder pulled along its generators has its constant stress, a cone converges to it. Where no
/// force stands the rule only renames u_i, so inextensional modes are as without it; straight sides beside
/// quadrilaterals make coarse, distorted mixed meshes stiffer, which dies out with h^2. A side has no part in u_i where
/// supports hold the drilling rotations of both ends, if only nearly: along planes of symmetry of a doubly curved
/// surface, the normals of the triangles lean, and bending would pass for drilling.
///
/// **Held rotations.** A support, or a constraint of one node alone, that holds the rotation of a node about the normal
/// of a shell holds the surface itself against turning, which is meant along clamped edges and planes of symmetry.
/// Where all corners of an element of a flat surface are held so, and one of them can move in the plane, the rotations
/// are held everywhere because in most programs nothing stiffens them: these corners follow the turn of each of their
/// elements. Triangles whose corners all follow are those of constant strain, and such quadrilaterals have no drilling
/// stiffness.
class ShellEdges {
public:
  /// Of the shells of a model with its supports.
  explicit ShellEdges(const FiniteElementModel& model);

  [[nodiscard]] const DrillingOptions& drilling(Eigen::Index cell) const { return of(cell).drilling; }
  /// What adds to the motions of a cell's nodes to make those of its corners.
  [[nodiscard]] const std::vector<EdgeShare>& shares(Eigen::Index cell) const { return of(cell).shares; }
  /// Motions of a cell's corners, 6 to a corner, from those of all nodes.
  [[nodiscard]] Eigen::VectorXd corner_motions(const Mesh& mesh, Eigen::Index cell, const Eigen::VectorXd& all) const;

private:
  struct CellEdges {
    DrillingOptions drilling;
    std::vector<EdgeShare> shares;
  };
  [[nodiscard]] const CellEdges& of(Eigen::Index cell) const {
    static const CellEdges usual;
    const auto own = cells_.find(cell);
    return own == cells_.end() ? usual : own->second;
  }

  std::unordered_map<Eigen::Index, CellEdges> cells_;  ///< those that differ from the usual
};

}  // namespace kalfem
