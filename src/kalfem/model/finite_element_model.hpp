// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Sparse>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Node set of a model whose nodes are no places: scalar points and generalised coordinates, each with one motion x
/// that is a number and not a displacement. They take no part in rigid-body motions.
inline constexpr const char* scalar_points = "scalar points";

/// Degrees of freedom of a node, in this order everywhere.
inline constexpr std::array<const char*, 6> direction_names = {"x", "y", "z", "rx", "ry", "rz"};
/// Index of a direction by its name, -1 where there is none.
int direction_index(const std::string& name);

/// One degree of freedom of one node.
struct NodalDof {
  Eigen::Index node = 0;
  int direction = 0;  ///< 0 .. 5
  friend auto operator<=>(const NodalDof&, const NodalDof&) = default;
};
/// sum_i coefficient_i z_i.
using DofSum = std::vector<std::pair<NodalDof, double>>;

/// Mass and inertia at a node, its centre moved from the node by `offset`.
struct PointMass {
  std::string name;
  Eigen::Index node = 0;
  double mass = 0.0;                                  ///< [kg]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about its own centre, global axes [kg m^2]
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   ///< [m]
};

/// Linear spring and dashpot along one degree of freedom: between two nodes, or from a node to a ground.
struct NodalSpring {
  std::string name;
  NodalDof from;
  std::optional<NodalDof> to = {};  ///< empty: the ground of that name
  std::string ground = "ground";
  double stiffness = 0.0;  ///< [N/m] or [N m/rad]
  double damping = 0.0;    ///< [N s/m] or [N m s/rad]
};

/// Linear spring and dashpot on any deformation d = sum_i coefficient_i z_i: along an oblique axis, with lever arms.
struct JointSpring {
  std::string name;
  std::vector<std::pair<NodalDof, double>> deformation;
  double stiffness = 0.0;  ///< [N/m] or [N m/rad]
  double damping = 0.0;    ///< [N s/m] or [N m s/rad]
  bool is_bar = false;     ///< along the line between two nodes and turning with it: an axial force stiffens it across
};

/// Matrices between degrees of freedom as they are: from another code, or a body of six masses and products. Empty ones
/// count as 0.
struct NodalMatrices {
  std::string name;
  std::vector<NodalDof> dofs;
  Eigen::SparseMatrix<double> stiffness, mass,
      damping;              ///< dofs x dofs, symmetric, both triangles
  std::string factor = {};  ///< name of the PartFactor that multiplies them; empty: none
};

/// Which matrices of its elements a factor multiplies.
enum class FactorOf { stiffness, mass, both };

/// A dimensionless factor a of a part of the model, the parameter "<name>.factor":
///     K = K_0 + a K_i,   M = M_0 + a M_i,   C = C_0 + a C_i.
/// The part is the elements of `cells` and every NodalMatrices that bears the factor's name. An element in the parts of
/// several factors is multiplied by each. Stresses are those of the stiffness that it leaves.
struct PartFactor {
  std::string name;
  double value = 1.0;
  std::vector<Eigen::Index> cells = {};
  FactorOf of = FactorOf::stiffness;  ///< what of the elements it multiplies
};

/// Nodes that move as one rigid body with their master (RBE2).
struct RigidLink {
  std::string name;
  Eigen::Index master = 0;
  std::vector<Eigen::Index> slaves;
  std::array<bool, 6> tied = {true, true, true, true, true, true};  ///< directions of the slaves that follow
  SourceLocation where = {};                                        ///< in the deck or case, for messages
};

/// A node that follows others by their weighted mean motion (RBE3): the rigid-body motion q about it that fits theirs
/// best, q = (sum S_i^T W_i S_i)^-1 sum S_i^T W_i z_i, with the rigid motion S_i q of node i and the weights W_i of its
/// directions, those of rotations times the square of the mean distance. A load on it reaches the others without
/// stiffening them.
struct WeightedLink {
  std::string name;
  Eigen::Index follower = 0;
  std::array<bool, 6> tied = {true, true, true, true, true, true};  ///< directions of the follower
  struct Share {
    Eigen::Index node = 0;
    double weight = 1.0;
    std::array<bool, 6> directions = {true, true, true, false, false, false};
  };
  std::vector<Share> shares;
  SourceLocation where = {};  ///< in the deck, for messages
};

/// sum_i coefficient_i z_i = 0; the first degree of freedom follows from the others.
struct MultiPointConstraint {
  std::string name;
  DofSum terms;
  SourceLocation where = {};  ///< in the deck, for messages
};

/// Degrees of freedom that do not move.
struct FixedNodes {
  std::string name;
  std::vector<Eigen::Index> nodes;
  std::array<bool, 6> directions = {true, true, true, true, true, true};
};

/// A linear finite-element substructure as the user describes it. Cells belong to regions of the mesh; each region that
/// has a property is part of the model, others are not. Point cells need none.
struct FiniteElementModel {
  std::string name;
  Mesh mesh;
  std::map<std::string, IsotropicMaterial> materials;
  std::map<std::string, RegionProperty> properties;  ///< by region
  std::vector<PointMass> masses;
  std::vector<NodalSpring> springs;
  std::vector<JointSpring> joints;
  std::vector<NodalMatrices> matrices;
  std::vector<PartFactor> factors;
  std::vector<RigidLink> links;
  std::vector<WeightedLink> weighted_links;
  std::vector<MultiPointConstraint> constraints;
  std::vector<FixedNodes> fixed;
  /// Nodes amid the sides of quadratic shells that linear ones replace, and the two corners beside each. A force on one
  /// acts as on the quadratic side, see nodal_forces().
  std::map<Eigen::Index, std::array<Eigen::Index, 2>> side_middles;
  MassKind mass_kind = MassKind::consistent;
};

/// "n17.rx": the degree of freedom by its node's number and its direction.
std::string dof_name(std::int64_t node_id, int direction);
std::string dof_name(const Mesh& mesh, const NodalDof& dof);

/// Every problem that can be found without assembling: regions of lines or surfaces whose cells have no property,
/// materials that are missing or not physical, properties on cells of the wrong dimension, nodes that do not exist,
/// names given twice, springs and masses that are not physical, links and constraints that contradict each other.
std::vector<Issue> validate(const FiniteElementModel& model);

}  // namespace kalfem
