// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

std::string message(auto&& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

struct Case {
  const char* text;
  const char* unit;
  double value;
};

// Values from the definitions of the SI (BIPM brochure, 9th edition) and of the international inch and pound (1959).
TEST(Units, ConvertToSi) {
  const Case cases[] = {{"15 %", "-", 0.15},
                        {"3 um/m", "-", 3e-6},
                        {"3 ppm", "m/m", 3e-6},
                        {"3 microstrain", "m/m", 3e-6},
                        {"3 ustrain", "m/m", 3e-6},
                        {"3 µε", "m/m", 3e-6},
                        {"3 uE", "m/m", 3e-6},
                        {"3 mm", "m", 3e-3},
                        {"0.5 s", "s", 0.5},
                        {"20 kN/m", "N/m", 2e4},
                        {"20kN/m", "N/m", 2e4},
                        {"10 N s/m", "N s/m", 10.0},
                        {"10 N*s/m", "kg/s", 10.0},
                        {"10 N·s·m^-1", "kg/s", 10.0},
                        {"100 Hz", "Hz", 100.0},
                        {"100 1/s", "Hz", 100.0},
                        {"2e-3 m/s^2/sqrt(Hz)", "m/s^2/sqrt(Hz)", 2e-3},
                        {"4 mm^2/s^4/Hz", "m^2/s^3", 4e-6},
                        {"180 deg", "rad", std::numbers::pi},
                        {"180 °", "-", std::numbers::pi},
                        {"60 rpm", "rad/s", 2.0 * std::numbers::pi},
                        {"2 g0", "m/s^2", 19.6133},
                        {"2 gn", "m/s^2", 19.6133},
                        {"5 g", "kg", 5e-3},
                        {"90 km/h", "m/s", 25.0},
                        {"210 GPa", "N/m^2", 210e9},
                        {"3 MPa", "Pa", 3e6},
                        {"2 kg m^2", "kg m^2", 2.0},
                        {"2 kg·m²", "kg m^2", 2.0},
                        {"3 m⁻¹", "1/m", 3.0},
                        {"10 in", "m", 0.254},
                        {"1 lbf", "N", 4.4482216152605},
                        {"1 psi", "Pa", 6894.757293168361},
                        {"7.85e-9 t/mm^3", "kg/m^3", 7850.0},
                        {"2 min", "s", 120.0},
                        {"4 N/(m s)", "N/m/s", 4.0},
                        {"9 (N)^(1/2)", "N^0.5", 9.0},
                        {"5 um", "m", 5e-6},
                        {"5 µm", "m", 5e-6},
                        {"6 m/s2", "m/s^2", 6.0},
                        {"100 mV/g0", "V s^2/m", 0.1 / 9.80665},
                        {"7", "kg", 7.0},
                        {"-1.5e3", "N", -1500.0},
                        {"+4 N", "N", 4.0},
                        {"4 -", "", 4.0}};
  for (const auto& each : cases)  // a few roundings of factors
    EXPECT_NEAR(to_si(each.text, each.unit), each.value, 4e-16 * std::abs(each.value) * 4) << each.text;
}

TEST(Units, AWrongUnitIsNamed) {
  EXPECT_NE(message([] { to_si("3 mm", "kg"); }).find("3 mm given where kg is required"), std::string::npos);
  EXPECT_NE(message([] { to_si("3 mm", "-"); }).find("3 mm given where a number without a unit is required"),
            std::string::npos);
  EXPECT_NE(message([] { to_si("2 g", "m/s"); }).find("2 g given where m/s is required"), std::string::npos);
  EXPECT_NE(message([] { to_si(parse_quantity("3 mm"), "kg"); }).find("0.003 m given where kg"), std::string::npos);
}

TEST(Units, AngularVelocityIsNotAFrequency) {
  EXPECT_THROW(to_si("10 rad/s", "Hz"), InvalidInput);
  EXPECT_THROW(to_si("10 Hz", "rad/s"), InvalidInput);
  EXPECT_THROW(to_si("600 rpm", "Hz"), InvalidInput);
  EXPECT_EQ(to_si("10 N m/rad", "N m"), 10.0);
}

TEST(Units, RefusesWhatItDoesNotUnderstand) {
  for (const char* text :
       {"",      " ",           "abc",  "nan",  "inf",      "-inf",    "1e999",    "1,5",    "3 foo",
        "3 m/",  "3 m^",        "3 (m", "3 m)", "3 sqrt(m", "3 N/m s", "3 m^0.3",  "3 m^99", "3 m^nan",
        "3 kkg", "1e300 Tm^12", "0x10", "3 m⁻", "3 ^2",     "3 %%",    "1e308 km", "+-3",    "3 \xC2"})
    EXPECT_THROW(parse_quantity(text), InvalidInput) << text;
  EXPECT_THROW(parse_quantity("1 " + std::string(100000, '(')), InvalidInput);
}

TEST(Units, SiUnitReadsBack) {
  for (const char* text : {"m/s^2/sqrt(Hz)", "N", "kg m^2", "-", "m^(1/3)", "rad/s", "K A^-2"}) {
    const Dimension dimension = parse_unit(text).dimension;
    const Unit back = parse_unit(si_unit(dimension));
    EXPECT_EQ(back.dimension, dimension) << text;
    EXPECT_EQ(back.factor, 1.0) << text;
  }
}

/// Standard gravity, 9.80665 m/s^2 (CGPM 1901).
TEST(Units, GBesideAnAccelerationIsStandardGravity) {
  EXPECT_DOUBLE_EQ(parse_unit_as("g", "m/s^2").factor, 9.80665);
  EXPECT_DOUBLE_EQ(to_si("0.02 g", "m/s^2"), 0.02 * 9.80665);
  EXPECT_DOUBLE_EQ(to_si(" +3e-1 mg ", "m/s^2"), 3e-4 * 9.80665);
  EXPECT_NE(message([&] { to_si("0.02 kg", "m/s^2"); }), "");
  EXPECT_DOUBLE_EQ(parse_unit_as(" G", "m/s^2").factor, 9.80665);
  EXPECT_DOUBLE_EQ(parse_unit_as("mg", "m/s^2").factor, 9.80665e-3);
  EXPECT_DOUBLE_EQ(parse_unit_as("g0", "m/s^2").factor, 9.80665);
  EXPECT_DOUBLE_EQ(parse_unit_as("g/N", "m/s^2/N").factor, 9.80665);
  EXPECT_DOUBLE_EQ(parse_unit_as("g/sqrt(Hz)", "m/s^2/sqrt(Hz)").factor, 9.80665);
  EXPECT_DOUBLE_EQ(parse_unit_as("cm/s^2", "m/s^2").factor, 0.01);
  // Grams stay grams, and a kilogram is no acceleration.
  EXPECT_DOUBLE_EQ(parse_unit_as("g", "kg").factor, 1e-3);
  EXPECT_DOUBLE_EQ(parse_unit_as("kN", "N").factor, 1e3);
  EXPECT_DOUBLE_EQ(parse_unit_as("1/g", "1/kg").factor, 1e3);
  for (const char* wrong : {"kg", "s", "m", "m/s", "%", "-", "V", "counts", "N"})
    EXPECT_NE(message([&] { parse_unit_as(wrong, "m/s^2"); }), "") << wrong;
  EXPECT_NE(message([&] { parse_unit_as("g", "m"); }), "");
}

}  // namespace
}  // namespace kalfem
