// SPDX-License-Identifier: Apache-2.0
#include "base/figures.hpp"

namespace kalfem::test {
namespace {

TEST(Figures, AreReadWithTheirLastDigit) {
  const auto expect = [](const std::string& text, double value, double last_digit) {
    const auto figure = parse_figure(text);
    ASSERT_TRUE(figure) << text;
    EXPECT_DOUBLE_EQ(figure->value, value) << text;
    EXPECT_NEAR(figure->last_digit / last_digit, 1.0, 1e-14) << text;  // rounding of a power of ten
  };
  expect("0.24 %", 0.0024, 1e-4);
  expect("-3.1", -3.1, 0.1);
  expect(".989", 0.989, 1e-3);
  expect("1.6e-5", 1.6e-5, 1e-6);
  expect("18", 18.0, 1.0);
  for (const std::string text : {"", "about 3", "3 mm", "%"}) EXPECT_FALSE(parse_figure(text)) << text;
}

TEST(Figures, AgreeToOneInTheLastDigit) {
  const auto figure = parse_figure("0.24 %");
  ASSERT_TRUE(figure);
  EXPECT_TRUE(figure->agrees_with(0.0024));
  EXPECT_TRUE(figure->agrees_with(0.00249));
  EXPECT_FALSE(figure->agrees_with(0.00252));
  EXPECT_FALSE(figure->agrees_with(0.00228));
}

}  // namespace
}  // namespace kalfem::test
