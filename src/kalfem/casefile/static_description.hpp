// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/finite_element_description.hpp"

/// Load cases as the case file states them, see description.hpp.
namespace kalfem::description {

/// On a named node, a node by its number, or spread over a group: evenly over lines and surfaces, in equal parts over
/// nodes.
struct StaticForce {
  Name at;
  std::array<double, 3> force{}, moment{};  ///< [N], [N m]
};
/// On the shells of a region, on the faces that a group of surfaces or nodes marks.
struct StaticPressure {
  Name on;
  double pressure = 0.0;  ///< [Pa]
};
/// Steady rotation about an axis.
struct StaticRotation {
  std::array<double, 3> axis{};   ///< direction
  std::array<double, 3> about{};  ///< a point of the axis [m]
  double speed = 0.0;             ///< [rad/s]
};
/// Loads that act together.
struct StaticCase {
  std::vector<StaticForce> forces;
  std::vector<StaticPressure> pressures;
  std::array<double, 3> gravity{};  ///< [m/s^2]
  std::optional<StaticRotation> rotation;
  Named<Value> displacements;  ///< imposed, by node.direction [m], of a rotation [rad]
};
/// Static analysis of one finite-element substructure.
struct Statics {
  Name substructure;
  Named<Located<StaticCase>> cases;
  Located<bool> deck_cases;  ///< the load cases of its deck too
  std::vector<Name> points;  ///< whose displacement and stress are reported; if empty, all named nodes
};

}  // namespace kalfem::description
