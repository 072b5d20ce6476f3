// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/display_unit.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace kalfem::test {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

TEST(DisplayUnit, BringsValuesBetweenOneAndAThousand) {
  const auto unit = [](const std::string& unit, double value) { return DisplayUnit(unit, {value}).unit(); };
  EXPECT_EQ(unit("Pa", 2.1e11), "GPa");
  EXPECT_EQ(unit("Pa", -2.1e9), "GPa");
  EXPECT_EQ(unit("N/m", 999.9), "N/m");
  EXPECT_EQ(unit("N/m", 1000.0), "kN/m");
  EXPECT_EQ(unit("N s/m", 1.2e4), "kN s/m");
  EXPECT_EQ(unit("N/m^3", 1.2e7), "MN/m^3");
  EXPECT_EQ(unit("m", 0.0032), "mm");
  EXPECT_EQ(unit("m", 4200.0), "m");
  EXPECT_EQ(unit("s", 8e-6), "µs");
  EXPECT_EQ(unit("m/s^2", 0.15), "mm/s^2");
  for (const std::string whole : {"kg", "m^2", "kg m^2", "1/s", "rad", "", "g"}) EXPECT_EQ(unit(whole, 2e-5), whole);
  EXPECT_EQ(DisplayUnit("N", {0.0, none, 5e3}).unit(), "kN");  // the first that says anything
  EXPECT_EQ(DisplayUnit("N", {0.0, none}).unit(), "N");
}

TEST(DisplayUnit, KeepsTheUnitOfTheUser) {
  const DisplayUnit millimetres("N/m", {2.1e8}, "N/mm");
  EXPECT_EQ(millimetres.unit(), "N/mm");
  EXPECT_EQ(millimetres.value(2.1e8, 5e5), "210000");
  EXPECT_EQ(DisplayUnit("m", {1e-3}, "in").value(0.0254), "1");
  const DisplayUnit too_large("N/m^3", {1.2e7}, "N/m^3");
  EXPECT_EQ(too_large.value(1.2e7, 6e4) + " " + too_large.unit(), "12.000 MN/m^3");
}

TEST(DisplayUnit, ShowsTwoDigitsOfTheDeviation) {
  const DisplayUnit newton("N/m", {17984.0}), pascal("Pa", {2.1e11}), none_of_it("kg", {12345.0});
  EXPECT_EQ(newton.value(17984.3, 31.2), "17.984");
  EXPECT_EQ(newton.deviation(31.2), "0.031");
  EXPECT_EQ(newton.value(17984.3, 3120.0), "18.0");
  EXPECT_EQ(pascal.value(2.0996e11, 1.3e8), "209.96");
  EXPECT_EQ(none_of_it.value(12345.0, 450.0), "12350");
  EXPECT_EQ(none_of_it.value(12345.0, 45.0), "12345");
  EXPECT_EQ(none_of_it.value(1.2345, 0.0996), "1.23");
  EXPECT_EQ(none_of_it.deviation(0.0996), "0.10");
  EXPECT_EQ(newton.value(17984.3), "17.98");
  EXPECT_EQ(newton.value(17984.3, none), "17.98");
  EXPECT_EQ(newton.value(none, 1.0), "-");
  EXPECT_EQ(newton.deviation(none), "-");
}

}  // namespace
}  // namespace kalfem::test
