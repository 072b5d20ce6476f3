// SPDX-License-Identifier: Apache-2.0
#include "correlation/tested_structures.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem::test {
namespace {

/// A cantilever plate lies between a beam, omega = 3.516 sqrt(E h^2 / 12 rho) / l^2, and a strip that cannot bend
/// across, with E / (1 - nu^2).
TEST(TestedStructures, APlateLiesBetweenABeamAndAStrip) {
  const auto frequencies = lowest_normal_modes(plate(12, 9).model(), {.count = 2}).frequencies;
  const double D = 210e9 * 1e-6 / (12.0 * 0.91), of_strip = 3.516 / (2.0 * M_PI * 1.44) * std::sqrt(D / 78.5);
  EXPECT_LT(frequencies[0], of_strip);
  EXPECT_GT(frequencies[0], std::sqrt(0.91) * of_strip * 0.99);  // 1 %: lumped masses
  EXPECT_GT(frequencies[1], 2.0 * frequencies[0]);
}

}  // namespace
}  // namespace kalfem::test
