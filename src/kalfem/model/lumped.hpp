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

/// Masses joined by springs and dashpots. Springs may end at a ground (the name `ground` or one of `grounds`), whose
/// motion is an input of the whole system. Without masses it is only a place for grounds.
struct LumpedSubstructure {
  std::string name;
  std::vector<LumpedMass> masses;
  std::vector<LumpedSpring> springs = {};
  std::vector<std::string> grounds = {"ground"};
  std::map<std::string, DofCombination> points = {};
  std::vector<double> modal_damping = {};  ///< ratio to critical per mode; the last one holds for all further modes
  RayleighDamping rayleigh = {};
};

/// Every problem of a lumped substructure: doubled or unknown names, non-positive masses, negative stiffness or
/// damping.
std::vector<Issue> validate(const LumpedSubstructure& substructure);

/// Assembles M, C and K. Modal and Rayleigh damping are of the substructure held as its springs hold it.
/// Throws InvalidInput with everything that validate() finds.
LinearModel assemble(const LumpedSubstructure& substructure);

}  // namespace kalfem
