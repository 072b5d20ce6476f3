// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Mass of one degree of freedom [kg], or moment of inertia of a rotation [kg m^2].
struct LumpedMass {
  std::string dof;
  double mass = 0.0;
};

/// Linear spring and dashpot between two points; a point is a degree of freedom, a named combination or a ground.
struct LumpedSpring {
  std::string name;
  std::string from;
  std::string to;
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
};

/// C = alpha M + beta K.
struct RayleighDamping {
  double mass_factor = 0.0;       ///< alpha [1/s]
  double stiffness_factor = 0.0;  ///< beta [s]
};

/// M, C and K between degrees of freedom as they are given. Empty ones count as 0.
struct LumpedMatrices {
  std::vector<std::string> dofs = {};
  SparseMatrix mass = {};       ///< [kg], dofs x dofs, symmetric
  SparseMatrix damping = {};    ///< [N s/m], dofs x dofs, symmetric
  SparseMatrix stiffness = {};  ///< [N/m], dofs x dofs, symmetric
};

/// Masses joined by springs and dashpots, and what is given as matrices. Springs may end at a ground (the name `ground`
/// or one of `grounds`), whose motion is an input of the whole system. Without masses it is only a place for grounds.
struct LumpedSubstructure {
  std::string name;
  std::vector<LumpedMass> masses;
  std::vector<LumpedSpring> springs = {};
  std::vector<std::string> grounds = {"ground"};
  std::map<std::string, DofCombination> points = {};
  std::vector<double> modal_damping = {};  ///< ratio to critical per mode; the last one holds for all further modes
  RayleighDamping rayleigh = {};
  LumpedMatrices matrices = {};  ///< of degrees of freedom before those of the masses
};

/// Its degrees of freedom: those of the matrices, then those of the masses.
std::vector<std::string> dofs_of(const LumpedSubstructure& substructure);

/// Every problem of a lumped substructure: doubled or unknown names, non-positive masses, negative stiffness or
/// damping, matrices of another size than their names, not symmetric or not finite.
std::vector<Issue> validate(const LumpedSubstructure& substructure);

/// Assembles M, C and K. Modal and Rayleigh damping are of the substructure held as its springs hold it.
/// Throws InvalidInput with everything that validate() finds.
LinearModel assemble(const LumpedSubstructure& substructure);

}  // namespace kalfem
