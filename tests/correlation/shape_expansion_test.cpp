// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/shape_expansion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "correlation/tested_structures.hpp"
#include "kalfem/correlation/correlate.hpp"
#include "kalfem/correlation/modal_mixing.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<TestedStructure> structures() { return {mast(4), plane_frame(4, 2), plate(6, 5)}; }

/// A modal test of a structure whose members are softer and stiffer than the model's, in any scale and sign.
struct ExpandedTest {
  ExpandedTest(const TestedStructure& structure, double off, double noise, int sensors, int modes, unsigned seed)
      : random(seed), model(structure.model()) {
    std::vector<double> factors(structure.members.size());
    std::normal_distribution<double> normal;
    for (auto& factor : factors) factor = std::exp(off * normal(random));
    const NormalModes true_modes = lowest_normal_modes(structure.model(factors), {.count = modes});
    for (Index i = 0; i < model.size(); ++i) {
      const auto& name = model.dofs[static_cast<std::size_t>(i)];
      if (std::ranges::find(structure.axes, name.substr(name.rfind('.') + 1)) != structure.axes.end())
        rows.push_back(i);
    }
    std::ranges::shuffle(rows, random);
    rows.resize(static_cast<std::size_t>(sensors));
    for (const Index row : rows) points.push_back({{model.dofs[static_cast<std::size_t>(row)], 1.0}});
    truth = true_modes.shapes;
    for (Index j = 0; j < truth.cols(); ++j) {
      truth.col(j) *= 3.0 * (normal(random) < 0.0 ? -1.0 : 1.0);
      VectorXd shape = truth(rows, j);
      const double deviation = noise * shape.cwiseAbs().maxCoeff();
      for (double& entry : shape) entry += deviation * normal(random);
      measured.push_back({.frequency = true_modes.frequencies[j], .shape = shape, .shape_deviation = 0.05});
    }
  }

  [[nodiscard]] Correlation correlated(ExpansionMethod method) const {
    std::vector<ShapeSensor> sensors;
    for (const auto& point : points) sensors.push_back({point.begin()->first, point.begin()->first});
    return correlate(measured, points, sensors, model, {.expansion = method});
  }

  std::mt19937 random;
  LinearModel model;
  std::vector<Index> rows;
  std::vector<DofCombination> points;
  std::vector<MeasuredMode> measured;
  MatrixXd truth;  ///< in the scale of the measured shapes
};

constexpr ExpansionMethod methods[] = {ExpansionMethod::model, ExpansionMethod::serep, ExpansionMethod::dynamic};

TEST(ShapeExpansion, OfTheModelsOwnShapesIsExact) {
  for (const auto& structure : structures())
    for (const auto method : methods) {
      const ExpandedTest given(structure, 0.0, 0.0, 16, 5, 1);
      const auto expansion = given.correlated(method).expansion;
      ASSERT_EQ(expansion.shapes.size(), 5U);
      for (const auto& each : expansion.shapes) {
        const VectorXd truth = given.truth.col(static_cast<Index>(each.measured));
        EXPECT_LT((each.shape - truth).norm(), 2e-3 * truth.norm());
        EXPECT_LT(each.deviation.norm(), 1e-2 * truth.norm());
      }
    }
}

/// u_f = -Z_ff^-1 Z_fm u_m [Kid73].
TEST(ShapeExpansion, DynamicIsThePartitionedOne) {
  const ExpandedTest given(mast(3), 0.1, 0.01, 12, 4, 2);
  const auto found = given.correlated(ExpansionMethod::dynamic).expansion;
  std::vector<Index> free;
  for (Index i = 0; i < given.model.size(); ++i)
    if (std::ranges::find(given.rows, i) == given.rows.end()) free.push_back(i);
  for (const auto& each : found.shapes) {
    const auto& measured = given.measured[each.measured];
    const double squared = std::pow(2.0 * std::numbers::pi * measured.frequency, 2);
    const MatrixXd stiffness = MatrixXd(given.model.stiffness) - squared * MatrixXd(given.model.mass);
    const VectorXd expected = -MatrixXd(stiffness(free, free)).lu().solve(stiffness(free, given.rows) * measured.shape);
    EXPECT_LT((each.shape(free) - expected).norm(), 1e-8 * expected.norm());
    EXPECT_LT((each.shape(given.rows) - measured.shape).norm(), 1e-8 * measured.shape.norm());
  }
}

/// u = Phi (P Phi)^+ y [OCa89], entries being known alike.
TEST(ShapeExpansion, SerepIsThatOfThePairedModes) {
  const ExpandedTest given(plane_frame(3, 2), 0.1, 0.01, 12, 4, 3);
  const auto found = given.correlated(ExpansionMethod::serep);
  std::vector<Index> paired;
  for (const auto& pair : found.pairs) paired.push_back(*pair.model_mode - 1);
  const MatrixXd shapes = lowest_normal_modes(given.model, {.count = 10}).shapes(Eigen::all, paired);
  for (const auto& each : found.expansion.shapes) {
    const MatrixXd at_sensors = shapes(given.rows, Eigen::all);
    const VectorXd expected = shapes * at_sensors.colPivHouseholderQr().solve(given.measured[each.measured].shape);
    EXPECT_LT((each.shape - expected).norm(), 1e-8 * expected.norm());
  }
}

/// One interval of each test: at any degree of freedom, of any mode, 2 to 30 % of scatter in the stiffness of members
/// and noise of .2 or 2 %, stated as 5 %. What mixes modes best has the least error.
TEST(ShapeExpansion, IntervalsHoldTheTruth) {
  constexpr int tests = 480;
  std::map<ExpansionMethod, int> held, intervals;
  std::map<ExpansionMethod, double> size;
  const auto all = structures();
  for (int seed = 0; seed < tests; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed) + 77);
    const auto any = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    const double off[] = {0.02, 0.1, 0.3}, noise[] = {0.002, 0.02};
    const ExpandedTest given(all[static_cast<std::size_t>(seed % 3)], off[any(0, 2)], noise[any(0, 1)], any(8, 24),
                             any(4, 8), static_cast<unsigned>(seed));
    const int mode = any(0, static_cast<int>(given.measured.size()) - 1);
    const Index dof = any(0, static_cast<int>(given.model.size()) - 1);
    for (const auto method : methods) {
      const auto expansion = given.correlated(method).expansion;
      for (const auto& each : expansion.shapes)
        if (each.measured == static_cast<std::size_t>(mode)) {
          ++intervals[method];
          const double error = std::abs(each.shape[dof] - given.truth(dof, mode));
          held[method] += error < 1.96 * each.deviation[dof] ? 1 : 0;
          size[method] += (each.shape - given.truth.col(mode)).norm() / given.truth.col(mode).norm();
        }
    }
  }
  for (const auto method : methods) {
    const double count = intervals[method];
    std::cout << fmt::format("{}: {} of {}, mean error {:.3f}\n", word_of(method), held[method], count,
                             size[method] / count);
    EXPECT_GE(count, 400);
    EXPECT_NEAR(held[method], 0.95 * count, 2.58 * std::sqrt(0.95 * 0.05 * count)) << word_of(method);
  }
  EXPECT_LT(size[ExpansionMethod::model], 0.5 * size[ExpansionMethod::serep]);
  EXPECT_LT(size[ExpansionMethod::model], 0.5 * size[ExpansionMethod::dynamic]);
}

/// Nothing is stated of the errors; a mode that shares nothing with its pair is left out.
TEST(ShapeExpansion, NeedsNoStatedErrors) {
  ExpandedTest given(plate(4, 3), 0.05, 0.01, 12, 4, 4);
  const auto stated = given.correlated(ExpansionMethod::model).expansion;
  for (auto& mode : given.measured) mode.shape_deviation = 0.0;
  const auto found = given.correlated(ExpansionMethod::model).expansion;
  ASSERT_EQ(found.shapes.size(), 4U);
  for (std::size_t i = 0; i < found.shapes.size(); ++i) {
    EXPECT_LT((found.shapes[i].shape - stated.shapes[i].shape).norm(), 1e-12 * stated.shapes[i].shape.norm());
    EXPECT_TRUE(found.shapes[i].deviation.allFinite());
  }
  given.measured[0].shape.setZero();
  const NormalModes modes = lowest_normal_modes(given.model, {.count = 10});
  const auto left =
      expand_shapes({given.measured[0]}, {{.model = 0}}, given.points, given.model, modes, ExpansionMethod::model);
  EXPECT_TRUE(left.shapes.empty());
}

/// Shapes that the truth of ModalMixing makes.
TEST(ModalMixing, FindsTheErrorAndTheNoise) {
  const auto structure = mast(4);
  const NormalModes modes = lowest_normal_modes(structure.model(), {.count = 30});
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double error : {0.01, 0.1})
    for (const double noise : {0.5, 2.0}) {
      double off_error = 0.0, off_noise = 0.0;
      constexpr int tests = 20;
      for (int test = 0; test < tests; ++test) {
        std::vector<MatchedShape> shapes;
        for (Index mode = 0; mode < 8; ++mode) {
          VectorXd coordinates = mixing_deviations(modes.frequencies, mode, error);
          for (double& each : coordinates) each *= normal(random);
          coordinates[mode] = 1.0;
          const MatrixXd at_sensors = 300.0 * modes.shapes.topRows(24);  // deviations of 1 / 300
          VectorXd measured = at_sensors * coordinates;
          for (double& each : measured) each += noise * normal(random);
          shapes.push_back({measured, at_sensors, mode});
        }
        const auto found = fit_modal_mixing(shapes, modes.frequencies);
        off_error += std::log(found.stiffness_error / error) / tests;
        off_noise += std::log(found.noise / noise) / tests;
      }
      EXPECT_NEAR(off_error, 0.0, 0.15) << error << " " << noise;
      EXPECT_NEAR(off_noise, 0.0, 0.05) << error << " " << noise;
    }
}

}  // namespace
}  // namespace kalfem
