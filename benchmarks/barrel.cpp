// SPDX-License-Identifier: Apache-2.0
#include "barrel.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace kalfem::benchmarks {

std::string barrel_deck(int around, int rings) {
  constexpr double length = 0.9, end_radius = 0.24, bulge = 0.06;
  std::string deck = "SOL 103\nCEND\nBEGIN BULK\nMAT1,1,2.1E11,,0.3,7850.\nPSHELL,1,1,1.5E-3,1,,1\n";
  const auto id = [&](int ring, int place) { return 1 + ring * around + place % around; };
  char line[128];
  for (int ring = 0; ring < rings; ++ring) {
    const double height = double(ring) / (rings - 1), radius = end_radius + 4.0 * bulge * height * (1.0 - height);
    for (int place = 0; place < around; ++place) {
      const double angle = 2.0 * std::numbers::pi * place / around;
      std::snprintf(line, sizeof line, "GRID,%d,,%.6f,%.6f,%.6f\n", id(ring, place), radius * std::cos(angle),
                    radius * std::sin(angle), length * height);
      deck += line;
    }
  }
  for (int ring = 0; ring + 1 < rings; ++ring)
    for (int place = 0; place < around; ++place) {
      std::snprintf(line, sizeof line, "CQUAD4,%d,1,%d,%d,%d,%d\n", id(ring, place), id(ring, place),
                    id(ring, place + 1), id(ring + 1, place + 1), id(ring + 1, place));
      deck += line;
    }
  return deck + "ENDDATA\n";
}

}  // namespace kalfem::benchmarks
