#include "kalfem/model/checks/plausibility.hpp"

#include <cmath>

namespace kalfem {

const std::vector<UsualMaterial>& usual_materials() {
  static const std::vector<UsualMaterial> materials = {{"steel", 1.85e11, 2.2e11, 7600.0, 8200.0},
                                                       {"aluminium", 6.6e10, 8.0e10, 2550.0, 2950.0},
                                                       {"titanium", 1.0e11, 1.25e11, 4350.0, 4850.0},
                                                       {"magnesium", 4.0e10, 4.8e10, 1700.0, 1900.0},
                                                       {"cast iron", 0.9e11, 1.85e11, 6900.0, 7500.0},
                                                       {"copper or brass", 0.9e11, 1.4e11, 8200.0, 9000.0},
                                                       {"nickel alloy", 1.7e11, 2.3e11, 8100.0, 9000.0},
                                                       {"zinc alloy", 8.0e10, 1.1e11, 6500.0, 7200.0},
                                                       {"tungsten or molybdenum", 3.0e11, 4.2e11, 1.0e4, 1.95e4},
                                                       {"lead", 1.3e10, 2.0e10, 1.1e4, 1.15e4},
                                                       {"glass", 5.0e10, 9.0e10, 2200.0, 2600.0},
                                                       {"ceramic", 2.0e11, 4.5e11, 2800.0, 4100.0},
                                                       {"carbon-fibre composite", 4.0e10, 3.0e11, 1400.0, 1800.0},
                                                       {"glass-fibre composite", 8.0e9, 5.0e10, 1500.0, 2200.0},
                                                       {"concrete or stone", 1.5e10, 8.0e10, 1900.0, 3000.0},
                                                       {"wood", 5.0e9, 2.0e10, 300.0, 1100.0},
                                                       {"plastic", 1.5e8, 1.2e10, 850.0, 1500.0},
                                                       {"rubber", 3.0e5, 2.0e8, 850.0, 1500.0},
                                                       {"foam or honeycomb", 1.0e5, 3.0e9, 10.0, 450.0}};
  return materials;
}

const std::vector<UsualUnits>& usual_units() {
  constexpr double inch = 0.0254, foot = 0.3048, pound = 0.45359237, gravity = 9.80665;
  static const std::vector<UsualUnits> units = {
      {"mm, t, s (N, MPa)", "mm", "t", "s", 1e-3, 1e3, 1.0},
      {"mm, kg, ms (kN, GPa)", "mm", "kg", "ms", 1e-3, 1.0, 1e-3},
      {"mm, kg, s (mN, kPa)", "mm", "kg", "s", 1e-3, 1.0, 1.0},
      {"mm, g, ms (N, MPa)", "mm", "g", "ms", 1e-3, 1e-3, 1e-3},
      {"inch, lbf s^2/in, s (lbf, psi)", "inch", "lbf s^2/in", "s", inch, pound * gravity / inch, 1.0},
      {"foot, slug, s (lbf)", "foot", "slug", "s", foot, pound * gravity / foot, 1.0},
      {"m, t, s (kN, kPa)", "m", "t", "s", 1.0, 1e3, 1.0},
      {"cm, g, s (dyn)", "cm", "g", "s", 1e-2, 1e-3, 1.0},
      {"cm, kg, s", "cm", "kg", "s", 1e-2, 1.0, 1.0}};
  return units;
}

std::optional<UsualMaterial> usual_material(double youngs_modulus, double density) {
  for (const auto& usual : usual_materials())
    if (youngs_modulus >= usual.least_modulus && youngs_modulus <= usual.most_modulus &&
        density >= usual.least_density && density <= usual.most_density)
      return usual;
  return {};
}

double wave_speed(const IsotropicMaterial& material) {
  return material.density > 0.0 && material.youngs_modulus > 0.0 ? std::sqrt(material.youngs_modulus / material.density)
                                                                 : 0.0;
}

std::vector<UnitsGuess> units_that_fit(const IsotropicMaterial& material) {
  std::vector<UnitsGuess> fitting;
  for (const auto& units : usual_units()) {
    const double pascals = units.kilograms / (units.metres * units.seconds * units.seconds),
                 density = units.kilograms / std::pow(units.metres, 3);
    if (const auto usual = usual_material(material.youngs_modulus * pascals, material.density * density))
      fitting.push_back({units, *usual});
  }
  return fitting;
}

}  // namespace kalfem
