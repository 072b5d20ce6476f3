#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Stiffness and density of a kind of structural material, as the usual handbooks give them; ranges.
struct UsualMaterial {
  const char* name;
  double least_modulus, most_modulus;  ///< E [Pa]
  double least_density, most_density;  ///< rho [kg/m^3]
};

/// Steel, aluminium, titanium, ..., composites, wood, rubber, foam; the narrower kinds first.
const std::vector<UsualMaterial>& usual_materials();

/// Units in which decks are written.
struct UsualUnits {
  const char* name;                   ///< "mm, t, s (N, MPa)"
  const char* length;                 ///< as units of kalfem are written: "mm"
  const char* mass;                   ///< "t"
  const char* time;                   ///< "s"
  double metres, kilograms, seconds;  ///< of one unit of each in SI
};
const std::vector<UsualUnits>& usual_units();

/// The kind of material whose ranges hold these values in SI; none: no usual one.
std::optional<UsualMaterial> usual_material(double youngs_modulus, double density);

/// sqrt(E / rho), the speed of a longitudinal wave in a bar; 0 without density.
double wave_speed(const IsotropicMaterial& material);

/// A material's numbers as usual ones in other units than SI.
struct UnitsGuess {
  UsualUnits units;
  UsualMaterial material;
};

/// Units in which the numbers are those of a usual material, SI left out; the more common units first.
std::vector<UnitsGuess> units_that_fit(const IsotropicMaterial& material);

}  // namespace kalfem
