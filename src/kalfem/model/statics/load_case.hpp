// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Force and moment at a node, global axes.
struct NodeLoad {
  Eigen::Index node = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< [N m]
};

/// A shell, or a face of a solid, on which pressure can act.
struct LoadedFace {
  CellShape shape = CellShape::quadrilateral4;  ///< a triangle or quadrilateral, linear or quadratic
  std::array<Eigen::Index, 8> nodes = {};       ///< in the order of the shape; counter-clockwise seen from outside
};

/// Pressure that pushes against the outward normal of solids and against the normal of shells (on their top side).
struct SurfacePressure {
  std::vector<LoadedFace> faces;
  double pressure = 0.0;  ///< [Pa]
};

/// A load between the ends of a beam, as forces and moments at its two nodes, global axes, see beam_loads.hpp.
struct BeamLoad {
  Eigen::Index cell = 0;
  Eigen::Matrix<double, 12, 1> forces = Eigen::Matrix<double, 12, 1>::Zero();  ///< [N, N m]
};

/// A displacement [m] or rotation [rad] that is held at a value.
struct ImposedMotion {
  NodalDof dof;
  double value = 0.0;
  bool of_support = false;  ///< a support holds it there, and moves by this value
};

/// A field of acceleration that is linear in space, a(x) = constant + gradient x; a mass m at x has the force m a(x).
struct AccelerationField {
  Eigen::Vector3d constant;  ///< [m/s^2]
  Eigen::Matrix3d gradient;  ///< [1/s^2]

  AccelerationField(const Eigen::Vector3d& everywhere = Eigen::Vector3d::Zero())  // NOLINT: gravity is a field
      : constant(everywhere), gradient(Eigen::Matrix3d::Zero()) {}

  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& place) const { return constant + gradient * place; }
  AccelerationField& operator+=(const AccelerationField& other);
};

/// Steady rotation of the structure about an axis, seen from axes that turn with it.
struct Rotation {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< n, of any length but 0
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< c, a point of the axis [m]
  double speed = 0.0;                               ///< W [rad/s]
};

/// Loads that act together on a model, beside its supports.
struct LoadCase {
  std::string name;
  std::vector<NodeLoad> loads;
  std::vector<SurfacePressure> pressures;
  Eigen::Vector3d gravity =
      Eigen::Vector3d::Zero();            ///< acceleration of the field [m/s^2]: a mass m has the weight m g
  std::optional<Rotation> rotation = {};  ///< its centrifugal field acts on every mass
  std::vector<ImposedMotion> imposed;
  std::vector<BeamLoad> beam_loads = {};
  std::optional<std::vector<FixedNodes>> supports = {};  ///< instead of the model's
  bool of_deck = false;                                  ///< one of a deck's cases, which may load supports alone
  std::vector<LoadCase> preload = {};                    ///< none or one, whose stresses are in the stiffness

  /// Of gravity and rotation together.
  [[nodiscard]] AccelerationField field() const;
};

/// Whether a load case holds no load at all.
bool is_empty(const LoadCase& load_case);

/// Forces of the loads and pressures at every degree of freedom, 6 to a node; without gravity and rotation. Pressure is
/// integrated by the shape functions of the face, f_i = -p int N_i n dA, exactly for straight sides. A force at a node
/// amid the side of a quadratic shell that linear ones replace acts with 3/4 there and 1/8 at each of the side's ends,
/// so that the forces of a constant stress stay in equilibrium with it.
Eigen::VectorXd nodal_forces(const FiniteElementModel& model, const LoadCase& load_case);

/// Parts of a load that is spread evenly over cells, by node; they sum up to 1. Lines and surfaces count by their
/// length and area with their shape functions, exactly where sides are straight and quadrilaterals parallelograms;
/// other cells with equal parts.
std::map<Eigen::Index, double> uniform_shares(const Mesh& mesh, const std::vector<Eigen::Index>& cells);

/// Faces of a group on which pressure can act, cell by cell:
/// * a region of shells: these;
/// * cells without property (a surface group of a mesh): the shells and outer faces of solids that have just their
///   corners;
/// * nodes: the shells and outer faces of solids whose nodes are all among them.
/// An outer face belongs to one solid only. Empty where there are none.
std::vector<LoadedFace> faces_of_cells(const FiniteElementModel& model, const std::vector<Eigen::Index>& cells);
std::vector<LoadedFace> faces_between_nodes(const FiniteElementModel& model, const std::vector<Eigen::Index>& nodes);

}  // namespace kalfem
