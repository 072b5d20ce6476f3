// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/api/finite_elements.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// A force [N] and a moment [N m] in global axes, at a named node, at a node by its number, or spread over a region or
/// set of the mesh: evenly over lines and surfaces, in equal parts over nodes.
struct AppliedForce {
  std::string at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
};

/// Pressure on the shells of a region, or on the faces whose nodes are all in a set; it pushes against the outward
/// normal of solids and against the normal of shells.
struct AppliedPressure {
  std::string on;
  double pressure = 0.0;  ///< [Pa]
};

/// Loads that act together on finite elements, beside their supports.
struct StaticLoads {
  std::string name;
  std::vector<AppliedForce> forces = {};
  std::vector<AppliedPressure> pressures = {};
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();               ///< [m/s^2]
  std::optional<Rotation> rotation = {};                           ///< steady, of the whole substructure
  std::vector<std::pair<std::string, double>> displacements = {};  ///< imposed: {"tip.z", 2e-3} [m], "tip.rx" [rad]
};

/// Force and moment that a support, a ground, a joint to the ground or an imposed motion exerts.
struct SupportReaction {
  std::string name;
  Eigen::Vector3d force, moment;  ///< about `centre` [N], [N m]
  Eigen::Vector3d centre;         ///< middle of its nodes [m]
};

/// Motion of a named node, and the stress of the solids and shells that meet there.
struct NodeStatics {
  std::string name;
  Eigen::Matrix<double, 6, 1> displacement;                ///< [x y z rx ry rz] [m, rad]
  std::optional<Eigen::Matrix<double, 6, 1>> stress = {};  ///< [xx yy zz xy yz xz], global axes [Pa]: the largest mean
  std::optional<double> von_mises = {};                    ///< of it [Pa]
  Layer layer = Layer::solid;                              ///< of a shell, where it is
};

/// The most stressed place of a region.
struct RegionPeak {
  std::string region;
  double stress = 0.0;       ///< von Mises stress of nodal means; of beams the axial stress with its sign [Pa]
  std::int64_t element = 0;  ///< by the mesh's numbers
  std::int64_t node = 0;
  Layer layer = Layer::solid;  ///< of a shell
  bool of_beam = false;
};

/// Equilibrium under one load case.
struct StaticsCase {
  std::string name;
  Eigen::MatrixXd displacements;           ///< of every node of the mesh, 6 x nodes [m, rad]
  std::vector<NodeStatics> nodes;          ///< named ones
  std::vector<RegionPeak> peaks;           ///< of each region that has stresses, the largest first
  std::vector<SupportReaction> reactions;  ///< of every support
  SupportReaction applied, reaction_sum;   ///< all loads, all reactions, about the middle of the model
  double imbalance = 0.0;                  ///< of loads and reactions, relative to the largest force
};

struct StaticsResult {
  std::vector<StaticsCase> cases;
  std::vector<std::string> warnings;  ///< load cases that are not in equilibrium with their reactions, in words
};

/// Linear statics K u = f of finite elements at full order, one solution a load case: what `static` of a case gives.
/// `deck_cases`: load cases of a deck, Deck::load_cases, which come behind. Throws InvalidInput with every argument
/// that is wrong, by its place ("cases[0] 'pull': forces[1]: there is no node or group 'tp'"), and where the supports
/// leave a motion free.
StaticsResult statics(const FiniteElements& elements, const std::vector<StaticLoads>& cases,
                      const std::vector<LoadCase>& deck_cases = {});

}  // namespace kalfem
