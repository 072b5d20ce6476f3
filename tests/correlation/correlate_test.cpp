// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/correlate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "correlation/tested_structures.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct Given {
  LinearModel model = mast(3).model();
  NormalModes modes = lowest_normal_modes(model, {.count = 6});
  std::vector<DofCombination> points;
  std::vector<ShapeSensor> sensors;
  std::vector<MeasuredMode> measured;

  Given() {
    for (std::size_t i = 0; i < model.dofs.size(); i += 2) {
      points.push_back({{model.dofs[i], 1.0}});
      sensors.push_back({"s" + std::to_string(i), model.dofs[i]});
    }
    const MatrixXd shapes = point_rows(model, points) * modes.shapes;
    for (const Index j : {2, 0, 4})
      measured.push_back({.frequency = 1.02 * modes.frequencies[j], .deviation = 1.0, .shape = -3.0 * shapes.col(j)});
  }
};

TEST(Correlate, ExactShapesAgreeEntirely) {
  const Given given;
  const auto found = correlate(given.measured, given.points, given.sensors, given.model);
  ASSERT_EQ(found.pairs.size(), 3U);
  const int expected[] = {3, 1, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(*found.pairs[i].model_mode, expected[i]);
    EXPECT_NEAR(found.pairs[i].mac, 1.0, 1e-12);
    EXPECT_NEAR(found.pairs[i].relative_error, 1.0 / 1.02 - 1.0, 1e-12);
    EXPECT_NEAR(found.mac(static_cast<Index>(i), expected[i] - 1), 1.0, 1e-12);
  }
  for (const auto& sensor : found.sensors) EXPECT_NEAR(sensor.comac, 1.0, 1e-12) << sensor.name;
  EXPECT_LT((found.orthogonality - MatrixXd::Identity(3, 3)).norm(), 1e-10);
  EXPECT_NEAR(found.auto_mac(1, 1), 1.0, 1e-14);
  EXPECT_NEAR(found.auto_mac(0, 1),
              std::pow(given.measured[0].shape.normalized().dot(given.measured[1].shape.normalized()), 2), 1e-14);
  EXPECT_TRUE(found.mistakes.empty());
}

/// f = phi_1 + 0.1 phi_2 in coordinates of the modes: 0.1 / sqrt(1.01) beside phi_2.
TEST(Correlate, OrthogonalityIsThatOfTheModes) {
  Given given;
  const MatrixXd shapes = point_rows(given.model, given.points) * given.modes.shapes;
  given.measured[1].shape = shapes.col(0) + 0.1 * shapes.col(2);
  const auto found = correlate(given.measured, given.points, given.sensors, given.model);
  EXPECT_NEAR(std::abs(found.orthogonality(0, 1)), 0.1 / std::sqrt(1.01), 1e-10);
  EXPECT_NEAR(found.orthogonality(1, 1), 1.0, 1e-12);
}

/// Gaps, a mode without a shape, and one that the model does not have.
TEST(Correlate, WhatWasNotMeasuredIsLeftOut) {
  Given given;
  given.measured[0].shape[1] = none;
  given.measured[1].shape.resize(0);
  given.measured[2].shape = Eigen::VectorXd::Unit(given.measured[2].shape.size(), 0);
  const auto found = correlate(given.measured, given.points, given.sensors, given.model);
  EXPECT_NEAR(found.pairs[0].mac, 1.0, 1e-12);
  EXPECT_FALSE(found.pairs[1].model_mode);
  EXPECT_FALSE(found.pairs[2].model_mode);
  EXPECT_LT(found.pairs[2].mac, 0.5);
  EXPECT_EQ(found.orthogonality.size(), 0);
  EXPECT_TRUE(std::isnan(found.sensors[0].comac));
  given.points[2] = {{"n99.x", 1.0}};
  EXPECT_THROW(correlate(given.measured, given.points, given.sensors, given.model), InvalidInput);
}

}  // namespace
}  // namespace kalfem
