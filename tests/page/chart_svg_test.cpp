// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/chart_svg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

namespace kalfem {
namespace {

Chart sine_chart(std::size_t samples) {
  Chart chart{.title = "Motion & rest", .x_label = "time [s]", .y_label = "displacement [m]"};
  Series estimate{.label = "estimate", .role = Role::estimate}, truth{.label = "truth", .role = Role::truth};
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = 0.001 * static_cast<double>(k), value = 2e-3 * std::sin(7.0 * t);
    chart.x.push_back(t);
    estimate.y.push_back(value);
    estimate.lower.push_back(value - 1e-4);
    estimate.upper.push_back(value + 1e-4);
    truth.y.push_back(value);
  }
  chart.series = {estimate, truth};
  return chart;
}

std::size_t count(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), expression), std::sregex_iterator()));
}

TEST(ChartSvg, HasTheSizeThatWasAskedFor) {
  const std::string svg = chart_svg(sine_chart(100), {.width = 17.0, .height = 6.0});
  EXPECT_NE(svg.find("width=\"17.000cm\" height=\"6.000cm\""), std::string::npos);
  EXPECT_NE(svg.find("viewBox=\"0 0 481.89 170.08\""), std::string::npos) << svg.substr(0, 300);
}

TEST(ChartSvg, SaysWhatStandsOnItsAxesAndInItsLegend) {
  const std::string svg = chart_svg(sine_chart(1000));
  EXPECT_NE(svg.find(">displacement [10⁻³ m]<"), std::string::npos);  // labels are short numbers
  EXPECT_NE(svg.find(">time [s]<"), std::string::npos);
  EXPECT_NE(svg.find(">\u22122<"), std::string::npos);  // -2e-3 m, with a minus sign
  EXPECT_NE(svg.find(">truth<"), std::string::npos);
  EXPECT_NE(svg.find("<title>Motion &amp; rest</title>"), std::string::npos);
  Chart alone = sine_chart(100);
  alone.series.resize(1);
  EXPECT_EQ(chart_svg(alone).find(">estimate<"), std::string::npos);  // one curve needs no legend
}

TEST(ChartSvg, ThinsLongRecordsAndKeepsTheirPeaks) {
  Chart chart = sine_chart(200000);
  chart.series.resize(1);
  chart.series[0].lower.clear();
  chart.series[0].upper.clear();
  chart.series[0].y[123457] = 0.5;
  const std::string svg = chart_svg(chart);
  EXPECT_LT(svg.size(), 40000U);
  std::smatch clip;
  ASSERT_TRUE(std::regex_search(
      svg, clip,
      std::regex("<clipPath[^>]*><rect x=\"[0-9.]+\" y=\"([0-9.]+)\" width=\"[0-9.]+\" height=\"([0-9.]+)\"")));
  // The range has 5 % of room at either end.
  const double peak = std::stod(clip[1]) + std::stod(clip[2]) * 0.05 / 1.1;
  double highest = std::numeric_limits<double>::infinity();
  const std::regex point("L[0-9.]+ ([0-9.]+)");
  for (std::sregex_iterator at(svg.begin(), svg.end(), point), end; at != end; ++at)
    highest = std::min(highest, std::stod((*at)[1]));
  EXPECT_NEAR(highest, peak, 0.01);
}

TEST(ChartSvg, LeavesGapsWhereNothingIsKnown) {
  Chart chart = sine_chart(100);
  for (std::size_t k = 40; k < 60; ++k)
    chart.series[0].y[k] = chart.series[0].lower[k] = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = chart_svg(chart);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(count(svg, "ZM"), 1U);  // two stretches of the band
}

TEST(ChartSvg, ShowsTheWindowOnly) {
  Chart chart = sine_chart(1000);
  chart.x_window = AxisRange{0.4, 0.5};
  const std::string svg = chart_svg(chart);
  EXPECT_NE(svg.find(">0.45<"), std::string::npos);
  EXPECT_EQ(svg.find(">0.8<"), std::string::npos);
}

TEST(ChartSvg, DrawsWhatHasNoExtent) {
  Chart chart{.title = "constant", .x_label = "x", .y_label = "y", .x = {0.0, 1.0}};
  chart.series = {{.label = "zero", .y = {0.0, 0.0}}, {.label = "nothing", .y = {NAN, NAN}}};
  const std::string svg = chart_svg(chart);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  Chart path{.title = "path",
             .x_label = "x",
             .y_label = "y",
             .series = {{.label = "p", .y = {0.0, 1.0}, .x = {5.0, 5.0}}},
             .scatter = true};
  EXPECT_EQ(chart_svg(path).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
