// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/heat_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kalfem {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

HeatMap small_map() {
  HeatMap map{.name = "<MAC>", .rows = {"1 & 2", "2"}, .columns = {"1", "2", "3"}};
  map.values = Eigen::MatrixXd{{1.0, 0.25, 0.0}, {std::nan(""), 0.998, 0.5}};
  return map;
}

TEST(HeatMap, DrawsASquareForEachNumber) {
  const std::string svg = heat_map_svg(small_map());
  EXPECT_EQ(count(svg, "<rect"), 5u) << "one is not a number";
  EXPECT_EQ(count(svg, ">0.25<"), 1u);
  EXPECT_EQ(count(svg, ">1<"), 3u) << "1.000, 0.998 and the name of a column";
  EXPECT_NE(svg.find("1 &amp; 2"), std::string::npos);
  EXPECT_NE(svg.find("&lt;MAC&gt;"), std::string::npos);
}

TEST(HeatMap, TellsNegativeNumbersByColourAndSign) {
  HeatMap map{.name = "r", .rows = {"a", "b"}, .columns = {"a", "b"}, .diverging = true};
  map.values = Eigen::MatrixXd{{1.0, -1.0}, {-0.3, 1.0}};
  const std::string svg = heat_map_svg(map);
  EXPECT_EQ(count(svg, "#b24800"), 1u) << "vermilion";
  EXPECT_EQ(count(svg, "#00609c"), 2u) << "blue";
  EXPECT_EQ(count(svg, ">−0.30<"), 1u);
}

TEST(HeatMap, LeavesOutNumbersThatDoNotFit) {
  HeatMap map{.name = "large", .values = Eigen::MatrixXd::Constant(40, 40, 0.25)};
  map.rows.assign(40, "r");
  map.columns.assign(40, "c");
  EXPECT_EQ(count(heat_map_svg(map), ">0.25<"), 0u);
}

}  // namespace
}  // namespace kalfem
