// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/report.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/page/chart_svg.hpp"
#include "kalfem/pictures/density_contour.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "steps/sample_inference.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

Eigen::Matrix2Xd normal_points(Index size, const Eigen::Matrix2d& factor) {
  RandomStream random(3, "points");
  return factor * Eigen::Matrix2Xd::NullaryExpr(2, size, [&] { return random.normal(); });
}

/// Twice the area inside of a contour that was cut into pieces, seen from the origin inside of it.
double area(const std::vector<ContourPiece>& pieces) {
  double sum = 0.0;
  for (const auto& [from, to] : pieces) sum += std::abs(from[0] * to[1] - from[1] * to[0]);
  return 0.5 * sum;
}

TEST(DensityContour, EnclosesTheShareOfANormalDistribution) {
  const Index size = 20000;
  const Eigen::VectorXd weights = Eigen::VectorXd::Constant(size, 1.0 / size);
  Eigen::Matrix2d factor;
  factor << 3.0, 0.0, 2.9, 0.2;  // correlation 0.998: an ellipse 15 times as long as it is wide
  const auto points = normal_points(size, factor);
  for (const double share : {0.5, 0.95}) {
    const auto pieces = density_contour(points, weights, share);
    const double expected = -2.0 * std::log(1.0 - share) * std::numbers::pi * factor.determinant();
    EXPECT_NEAR(area(pieces) / expected, 1.0, 0.12) << share;
  }
}

TEST(DensityContour, FollowsTheWeights) {
  Eigen::Matrix2Xd points = normal_points(4000, Eigen::Matrix2d::Identity());
  points.rightCols(2000).row(0).array() += 100.0;
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(4000, 1.0 / 2000.0);
  weights.tail(2000).setZero();
  for (const auto& [from, to] : density_contour(points, weights, 0.95)) EXPECT_LT(from[0], 10.0);
}

TEST(DensityContour, IsEmptyWherePointsDoNotSpread) {
  const Eigen::VectorXd weights = Eigen::VectorXd::Constant(100, 0.01);
  EXPECT_TRUE(density_contour(Eigen::Matrix2Xd::Constant(2, 100, 7.0), weights, 0.5).empty());
  Eigen::Matrix2Xd line = normal_points(100, Eigen::Matrix2d::Identity());
  line.row(1) = 2.0 * line.row(0);
  EXPECT_TRUE(density_contour(line, weights, 0.5).empty());
}

TEST(AxisTicks, AreRoundAndInside) {
  EXPECT_EQ(axis_ticks(0.0, 10.0, 3), (std::vector<double>{0.0, 5.0, 10.0}));
  const auto ticks = axis_ticks(2.0731e5, 2.1268e5, 3);
  ASSERT_FALSE(ticks.empty());
  EXPECT_LE(ticks.size(), 3u);
  for (const double tick : ticks) EXPECT_EQ(std::fmod(tick, 1000.0), 0.0);
  EXPECT_TRUE(axis_ticks(1.0, 1.0, 3).empty());
  EXPECT_TRUE(axis_ticks(0.0, std::nan(""), 3).empty());
}

TEST(CornerPlot, DrawsEveryPairOnce) {
  const auto picture = corner_plot(sample_inference());
  ASSERT_TRUE(picture);
  EXPECT_TRUE(picture->svg.starts_with("<svg"));
  EXPECT_EQ(count(picture->svg, "class=\"bars\""), 4);
  EXPECT_EQ(count(picture->svg, "class=\"contour\""), 6);
  EXPECT_EQ(count(picture->svg, "class=\"contour inner\""), 6);
  EXPECT_EQ(count(picture->svg, "rx=\"4\""), 6);
  EXPECT_EQ(count(picture->svg, "class=\"prior\""), 4);
  EXPECT_EQ(count(picture->svg, "class=\"mean\""), 4);
  EXPECT_EQ(count(picture->svg, "class=\"truth\""), 3 + 3 + 3 + 3) << "on the diagonal, and across the panels below";
  EXPECT_LE(count(picture->svg, "h0"), 6 * 600);
  EXPECT_GE(count(picture->svg, "h0"), 6 * 560);
  EXPECT_EQ(count(picture->svg, "nan"), 0);
  EXPECT_EQ(count(picture->svg, "<svg"), count(picture->svg, "</svg>"));
  EXPECT_LT(picture->svg.size(), 250000u);
}

TEST(CornerPlot, TakesTheStrongestCorrelationsOfMany) {
  InferenceOutcome outcome;
  for (int i = 0; i < 11; ++i) outcome.posterior.push_back(normal_summary("p" + std::to_string(i), 0.0, 1.0));
  outcome.correlation = Eigen::MatrixXd::Identity(11, 11);
  for (int i = 0; i < 11; ++i)
    for (int j = 0; j < 11; ++j)
      if (i != j) outcome.correlation(i, j) = i < 3 || j < 3 ? 0.0 : -0.5;
  EXPECT_EQ(drawn_parameters(outcome, 8), (std::vector<Index>{3, 4, 5, 6, 7, 8, 9, 10}));
  RandomStream random(1, "many");
  outcome.samples.values = Eigen::MatrixXd::NullaryExpr(11, 200, [&] { return random.normal(); });
  const auto picture = corner_plot(outcome);
  ASSERT_TRUE(picture);
  EXPECT_EQ(count(picture->svg, "class=\"bars\""), 8);
  EXPECT_EQ(count(picture->caption, "Of 11 parameters the 8 with the strongest correlations."), 1);
}

TEST(CornerPlot, TakesSamplesAsOftenAsTheirWeightsAsk) {
  auto outcome = sample_inference();
  outcome.samples.weights = Eigen::VectorXd::Zero(outcome.samples.values.cols());
  outcome.samples.weights.head(2).setConstant(0.5);
  const auto picture = corner_plot(outcome);
  ASSERT_TRUE(picture);
  EXPECT_EQ(count(picture->svg, "h0"), 6 * 2);
  outcome.samples.weights.setConstant(std::nan(""));
  EXPECT_FALSE(corner_plot(outcome));
  outcome.samples.values.resize(4, 0);
  EXPECT_FALSE(corner_plot(outcome));
}

}  // namespace
}  // namespace kalfem
