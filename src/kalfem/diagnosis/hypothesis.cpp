// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/hypothesis.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kalfem {

namespace {

struct UnitMistake {
  double factor;  ///< recorded number over the right one
  const char* words;
};

constexpr UnitMistake unit_mistakes[] = {{1.0 / 9.80665, "it is in g, not in m/s^2"},
                                         {9.80665, "it is in m/s^2, not in g"},
                                         {1e3, "it is in thousandths of the stated unit (mm, mV)"},
                                         {1e-3, "it is in thousands of the stated unit (m for mm, kN for N)"},
                                         {1e2, "it is in hundredths of the stated unit (cm, gal)"},
                                         {1e-2, "it is in hundreds of the stated unit (m for cm)"},
                                         {1e6, "it is in millionths of the stated unit"},
                                         {1e-6, "it is in millions of the stated unit"},
                                         {1.0 / 0.0254, "it is in inches, not in m"},
                                         {0.0254, "it is in m, not in inches"},
                                         {1.0 / 25.4, "it is in inches, not in mm"},
                                         {25.4, "it is in mm, not in inches"},
                                         {1e3 / 9.80665, "it is in milli-g, not in m/s^2"},
                                         {1.0 / 4.4482216, "it is in lbf, not in N"},
                                         {4.4482216, "it is in N, not in lbf"},
                                         {1.0 / 0.3048, "it is in feet, not in m"},
                                         {0.3048, "it is in m, not in feet"}};

}  // namespace

std::string in_words(double value) { return fmt::format("{:.3g}", value); }

std::optional<std::string> unit_mistake(double factor) {
  for (const auto& mistake : unit_mistakes)
    if (std::abs(std::abs(factor) / mistake.factor - 1.0) < 1e-9) return mistake.words;
  return std::nullopt;
}

std::vector<double> unit_factors_near(std::optional<double> factor, double tolerance) {
  if (!factor) return {1e3, 1e-3, 1e2, 1e-2, 9.80665, 1.0 / 9.80665};
  const auto distance = [&](double other) { return std::abs(std::log(std::abs(*factor) / other)); };
  std::vector<double> near;
  for (const auto& mistake : unit_mistakes)
    if (distance(mistake.factor) < tolerance) near.push_back(mistake.factor);
  std::ranges::sort(near, {}, distance);
  return near;
}

}  // namespace kalfem
