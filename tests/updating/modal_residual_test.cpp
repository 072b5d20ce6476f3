// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/worker_pool.hpp"
#include "model/fe_models.hpp"
#include "updating/affine_model.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using ModelPtr = std::shared_ptr<const AffineModel>;
/// Ten masses of 2 kg between springs of 1 kN/m and so, the first one to the ground.
ModelPtr chain() {
  std::vector<ChainSpring> springs;
  for (int i = 0; i < 10; ++i) springs.push_back({i - 1, i, 1000.0 + 30.0 * i});
  return shared(spring_model(std::vector<double>(10, 2.0), springs));
}

std::vector<DofCombination> points(const std::vector<std::string>& names) {
  std::vector<DofCombination> list;
  for (const auto& name : names) list.push_back({{name, 1.0}});
  return list;
}

const std::vector<std::string> four_places = {"m1", "m4", "m6", "m9"};

/// What an exact measurement of the model's elastic modes would give; shapes change sign and scale from mode to mode.
std::vector<MeasuredMode> measurement(const AffineModel& model, const VectorXd& parameters,
                                      const std::vector<DofCombination>& places, Index count, Index skip = 0) {
  const LinearModel at = model.at(parameters).model;
  const LowestModes modes = lowest_modes(at.stiffness, at.mass, {.count = count + skip});
  const MatrixXd shapes = point_rows(at, places) * modes.vectors;
  std::vector<MeasuredMode> measured;
  for (Index j = skip; j < count + skip; ++j) {
    const double frequency = std::sqrt(modes.values[j]) / (2.0 * M_PI);
    measured.push_back({frequency, 0.003 * frequency, {}, VectorXd((j % 2 ? -3.0 : 0.2) * shapes.col(j)), 0.02});
  }
  return measured;
}

void drop_shapes(std::vector<MeasuredMode>& measured) {
  for (auto& mode : measured) mode.shape.resize(0);
}

VectorXd softened(const AffineModel& model) {
  VectorXd parameters = model.start();
  for (Index i = 0; i < parameters.size(); ++i) parameters[i] *= 1.0 - 0.1 * std::sin(2.0 * double(i) + 1.0);
  return parameters;
}

/// `tolerance` is relative to the whole, with parameters scaled by their values.
void expect_jacobian(const ModalResidual& residual, const VectorXd& at, double step, double tolerance) {
  const auto value = residual.evaluate(at, true);
  ASSERT_TRUE(value);
  EXPECT_EQ(value->values.size(), residual.size());
  const MatrixXd differences = jacobian_by_differences(
      [&](const VectorXd& parameters) { return residual.evaluate(parameters, false).value().values; }, at, step);
  const MatrixXd scaled = value->jacobian * at.asDiagonal();
  EXPECT_GT(scaled.norm(), 1.0);
  for (Index row = 0; row < scaled.rows(); ++row)
    EXPECT_LT((scaled.row(row) - differences.row(row) * at.asDiagonal()).norm(), tolerance * scaled.norm()) << row;
}

TEST(ModalResidual, IsZeroAtTheTruth) {
  const auto model = chain();
  const VectorXd truth = softened(*model);
  const auto places = points(four_places);
  const ModalResidual residual(model, measurement(*model, truth, places, 5), places, model->start());
  EXPECT_EQ(residual.size(), 5 + 5 * 4);
  // rounding of the modes, over deviations of .003 and .02
  EXPECT_LT(residual.evaluate(truth, false)->values.norm(), 1e-12);
  EXPECT_GT(residual.evaluate(model->start(), false)->values.norm(), 10.0);
  for (const auto& row : residual.compare(truth).pairs) {
    EXPECT_NEAR(row.mac, 1.0, 1e-14);  // rounding
    EXPECT_NEAR(row.relative_error, 0.0, 1e-14);
    EXPECT_EQ(row.model_mode, static_cast<int>(row.measured) + 1);
  }
}

TEST(ModalResidual, ScaledByTheDeviations) {
  const auto model = chain();
  auto measured = measurement(*model, model->start(), points(four_places), 1);
  measured[0].frequency -= 2.0 * measured[0].deviation;
  VectorXd& shape = measured[0].shape;
  const VectorXd exact = shape, across = Eigen::Vector4d(exact[1], -exact[0], 0.0, 0.0).normalized();
  shape += 0.01 * across;  // the fit does not follow it
  const double deviation = 0.02 * shape.cwiseAbs().maxCoeff();
  const ModalResidual residual(model, measured, points(four_places), model->start());
  const VectorXd values = residual.evaluate(model->start(), false)->values;
  // rounding, over deviations of .003 and .02
  EXPECT_NEAR(values[0], 2.0, 2e-13);
  EXPECT_LT((values.tail(4) + 0.01 / deviation * across).norm(), 1e-13);
}

TEST(ModalResidual, JacobianOfAChainAgreesWithDifferences) {
  const auto model = chain();
  const auto places = points(four_places);
  auto measured = measurement(*model, softened(*model), places, 5);
  measured[3].shape.resize(0);
  const ModalResidual residual(model, measured, places, model->start());
  expect_jacobian(residual, model->start(), 2e-3, 1e-10);  // found 2e-11
}

TEST(ModalResidual, JacobianOfAPlateAgreesWithDifferences) {
  auto plate = model_of(plate_mesh(0.8, 0.5, 12, 10));
  plate.properties["plate"] = ShellProperty{"steel", 0.01};
  plate.springs = {{.name = "corner", .from = {0, 2}, .to = {}, .stiffness = 3e4}};
  plate.springs.push_back({.name = "middle", .from = {71, 2}, .to = {}, .stiffness = 1e5});
  const auto model = shared(fe_affine_model(plate, {"plate.thickness", "steel.density", "corner.stiffness"}));
  const auto places = points({"n1.z", "n13.z", "n40.z", "n72.z", "n131.z", "n143.z"});
  VectorXd truth = model->start();
  truth[0] *= 1.03, truth[2] *= 1.2;
  // four rigid motions and two on the springs lie below 40 Hz
  const auto measured = measurement(*model, truth, places, 4, 6);
  const ModalResidual residual(model, measured, places, model->start(), {.above = 40.0});
  EXPECT_EQ(residual.skipped(), 6);
  expect_jacobian(residual, model->start(), 1e-2, 4e-9);  // vectors of the Lanczos iteration over the step: found 4e-10
}

TEST(ModalResidual, NoisyModesGiveTheSpringsBack) {
  // 5 frequencies (0.1 %) and shapes at 4 points (0.5 %) for 4 unknown springs
  std::vector<ChainSpring> springs;
  for (int i = 0; i < 10; ++i) springs.push_back({i - 1, i, 1000.0});
  const auto all = shared(spring_model(std::vector<double>(10, 2.0), springs));
  const std::vector<Index> unknown = {0, 3, 5, 8};
  VectorXd truth = all->start();
  truth[0] = 800.0, truth[3] = 1300.0, truth[5] = 900.0, truth[8] = 1200.0;

  const auto places = points(four_places);
  auto measured = measurement(*all, truth, places, 5);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (auto& mode : measured) {
    mode.deviation = 0.001 * mode.frequency, mode.shape_deviation = 0.005;
    mode.frequency += mode.deviation * normal(random);
    const double spread = mode.shape_deviation * mode.shape.cwiseAbs().maxCoeff();
    for (double& entry : mode.shape) entry += spread * normal(random);
  }
  const ModalResidual residual(all, measured, places, all->start());

  VectorXd theta = all->start();
  MatrixXd J;
  for (int i = 0; i < 12; ++i) {
    const auto value = residual.evaluate(theta, true);
    ASSERT_TRUE(value) << i;
    J = value->jacobian(Eigen::all, unknown);
    const VectorXd step = -J.householderQr().solve(value->values);
    for (Index k = 0; k < 4; ++k) theta[unknown[std::size_t(k)]] += step[k];
  }
  const VectorXd deviations = (J.transpose() * J).inverse().diagonal().cwiseSqrt();
  for (Index k = 0; k < 4; ++k) {
    const Index spring = unknown[std::size_t(k)];
    // three deviations; found 2.1
    EXPECT_LT(std::abs(theta[spring] - truth[spring]), 3.0 * deviations[k]) << spring;
    EXPECT_LT(deviations[k], 0.02 * truth[spring]) << spring;  // found .4 to 1.0 %
  }
  const VectorXd last = residual.evaluate(theta, false)->values;
  // 25 values less 4 springs and 5 scales of shapes: 16, with a deviation of sqrt(2 * 16) = 5.7; found 18
  EXPECT_NEAR(last.squaredNorm(), 16.0, 2.0 * std::sqrt(32.0));
}

/// Two chains side by side: the frequencies of one pass those of the other as its springs stiffen, uncoupled.
ModelPtr twins(double second) {
  return shared(spring_model({1.0, 1.0, 1.0, 1.0}, {{-1, 0, 1000.0}, {0, 1, 1000.0}, {-1, 2, second}, {2, 3, second}}));
}

TEST(ModalResidual, FollowsModesThroughACrossingWithoutShapes) {
  const auto model = twins(900.0);
  const VectorXd start = model->start();
  auto measured = measurement(*model, start, points({"m0"}), 4);
  drop_shapes(measured);
  const ModalResidual residual(model, measured, {}, start);
  VectorXd stiffer = start;
  stiffer[2] = stiffer[3] = 1200.0;  // its modes now lie above their partners
  const auto rows = residual.compare(stiffer).pairs;
  const int expected[] = {2, 1, 4, 3};
  const double factor[] = {std::sqrt(1200.0 / 900.0), 1.0, std::sqrt(1200.0 / 900.0), 1.0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rows[i].model_mode, expected[i]) << i;
    EXPECT_NEAR(rows[i].model_frequency, factor[i] * measured[i].frequency, 5e-14);  // rounding
    EXPECT_NEAR(rows[i].mac, 1.0, 1e-14);
  }
  expect_jacobian(residual, stiffer, 2e-3, 5e-12);  // rounding over the step: found 4e-13
}

TEST(ModalResidual, PairsByShapeWhereTheStartHasAnotherOrder) {
  const auto model = twins(1200.0);
  const auto places = points({"m0", "m1", "m2", "m3"});
  VectorXd truth = model->start();
  truth[2] = truth[3] = 900.0;
  auto measured = measurement(*model, truth, places, 4);
  measured.erase(measured.begin() + 1);  // one is missing
  const ModalResidual residual(model, measured, places, model->start());
  const auto rows = residual.compare(model->start()).pairs;
  EXPECT_EQ(rows[0].model_mode, 2);
  EXPECT_EQ(rows[1].model_mode, 4);
  EXPECT_EQ(rows[2].model_mode, 3);
  EXPECT_LT(residual.evaluate(truth, false)->values.norm(), 1e-12);  // rounding, over deviations of .003 and .02
}

TEST(ModalResidual, NumbersDecideAtTheStart) {
  const auto model = twins(900.0);
  auto measured = measurement(*model, model->start(), points({"m0"}), 3);
  drop_shapes(measured);
  measured[0].model_mode = 2;
  measured[1].model_mode = 1;
  const ModalResidual residual(model, measured, {}, model->start());
  const auto rows = residual.compare(model->start()).pairs;
  EXPECT_EQ(rows[0].model_mode, 2);
  EXPECT_EQ(rows[1].model_mode, 1);
  EXPECT_EQ(rows[2].model_mode, 3);  // by order among the free ones
  EXPECT_NEAR(rows[0].relative_error, measured[1].frequency / measured[0].frequency - 1.0, 1e-14);  // rounding
}

TEST(ModalResidual, ANumberCountsMoreThanAnothersShape) {
  const auto model = twins(900.0);
  const auto places = points({"m0", "m1", "m2", "m3"});
  auto measured = measurement(*model, model->start(), places, 2);
  measured[0].model_mode = 2;  // whose shape the second has
  measured[0].frequency *= 3.0;
  const auto message = message_of([&] { ModalResidual(model, measured, places, model->start()); });
  EXPECT_NE(message.find("measured mode 2"), std::string::npos) << message;
  EXPECT_EQ(message.find("measured mode 1"), std::string::npos) << message;
}

TEST(ModalResidual, LowestModesThatAreNotElasticAreLeftOut) {
  // the free chain on a soft spring: one mode of 0.5 Hz or so
  std::vector<ChainSpring> springs = {{-1, 0, 20.0}};
  for (int i = 1; i < 6; ++i) springs.push_back({i - 1, i, 1000.0});
  const auto model = shared(spring_model(std::vector<double>(6, 0.3), springs));
  auto measured = measurement(*model, model->start(), points({"m0"}), 3, 1);
  drop_shapes(measured);
  const ModalResidual by_frequency(model, measured, {}, model->start(), {.above = 2.0});
  const ModalResidual by_number(model, measured, {}, model->start(), {.skip = 1});
  for (const auto* residual : {&by_frequency, &by_number}) {
    EXPECT_EQ(residual->skipped(), 1);
    EXPECT_LT(residual->evaluate(model->start(), false)->values.norm(), 1e-12);  // rounding, over a deviation of .003
  }
  springs.erase(springs.begin());
  const auto free = shared(spring_model(std::vector<double>(6, 0.3), springs));
  EXPECT_EQ(ModalResidual(free, measured, {}, free->start()).skipped(), 1);  // the rigid one
}

TEST(ModalResidual, RepeatedModesFitAnyCombination) {
  // two equal chains: the measured shapes are mixtures of each pair
  const auto model = twins(1000.0);
  const auto places = points({"m0", "m1", "m2", "m3"});
  auto measured = measurement(*model, model->start(), places, 4);
  const Eigen::Vector4d one(1.0, std::sqrt(5.0) / 2.0 + 0.5, 0.0, 0.0),
      other(0.0, 0.0, 1.0, std::sqrt(5.0) / 2.0 + 0.5);
  measured[0].shape = one + 0.4 * other, measured[1].shape = other - 0.4 * one;
  measured.resize(2);
  const ModalResidual residual(model, measured, places, model->start());
  // rounding, over deviations of .003 and .02
  EXPECT_LT(residual.evaluate(model->start(), false)->values.norm(), 3e-12);
  for (const auto& row : residual.compare(model->start()).pairs) EXPECT_NEAR(row.mac, 1.0, 1e-14);
  // the sum of the two frequencies and the space of the shapes are differentiable there
  const auto value = residual.evaluate(model->start(), true);
  ASSERT_TRUE(value);
  const auto sum = [&](const VectorXd& at) {
    const LinearModel moved = model->at(at).model;
    const LowestModes modes = lowest_modes(moved.stiffness, moved.mass, {.count = 2});
    return VectorXd(VectorXd::Constant(1, std::sqrt(modes.values[0]) + std::sqrt(modes.values[1])) / (2.0 * M_PI));
  };
  const MatrixXd difference = jacobian_by_differences(sum, model->start(), 2e-3);
  const VectorXd slopes = measured[0].deviation * (value->jacobian.row(0) + value->jacobian.row(1)).transpose();
  // differences of the fourth order: found 2e-12
  EXPECT_LT((slopes - difference.row(0).transpose()).norm(), 2e-11 * slopes.norm());
  // directions are those of the measured shapes, so each frequency feels both chains
  EXPECT_NEAR(value->jacobian(0, 2) / value->jacobian(0, 0), 0.16, 1e-13);  // rounding
}

/// A mass in the plane on two springs at right angles, both oblique to its degrees of freedom.
ModelPtr oblique_isolator() {
  LinearModel frame;
  frame.dofs = {"x", "y"};
  std::vector<AffineTerm> terms;
  for (int i = 0; i < 2; ++i) {
    const double angle = M_PI * (0.25 + 0.5 * i);
    const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
    terms.push_back({{{"k" + std::to_string(i), 1}}, SparseMatrix(MatrixXd(axis * axis.transpose()).sparseView())});
  }
  const SparseMatrix mass = MatrixXd(MatrixXd::Identity(2, 2)).sparseView();
  return shared({frame, terms, {{{}, mass}}, {"k0", "k1"}, {{"k0", 1000.0}, {"k1", 1000.0}}});
}

TEST(ModalResidual, SplitsARepeatedPairAlongItsParameters) {
  // the basis of the pair along x and y would feel both springs alike, and no step could part them
  const auto model = oblique_isolator();
  auto measured = measurement(*model, Eigen::Vector2d(950.0, 1080.0), points({"x"}), 2);
  drop_shapes(measured);
  const ModalResidual residual(model, measured, {}, model->start());
  VectorXd theta = model->start();
  for (int i = 0; i < 5; ++i) {
    const auto value = residual.evaluate(theta, true);
    ASSERT_TRUE(value) << i;
    EXPECT_GT(value->jacobian.col(0).norm(), 0.5 * value->jacobian.col(1).norm());
    // rounding
    EXPECT_NEAR(value->jacobian.col(0).dot(value->jacobian.col(1)), 0.0, 1e-15 * value->jacobian.squaredNorm());
    theta -= value->jacobian.colPivHouseholderQr().solve(value->values);
  }
  // the fifth step has only roundings left; which spring is the softer one, frequencies cannot say
  EXPECT_NEAR(std::min(theta[0], theta[1]), 950.0, 1e-11);
  EXPECT_NEAR(std::max(theta[0], theta[1]), 1080.0, 1e-11);
}

TEST(ModalResidual, EvaluatesInSeveralThreads) {
  const auto model = chain();
  const auto places = points(four_places);
  const ModalResidual residual(model, measurement(*model, softened(*model), places, 5), places, model->start());
  const VectorXd alone = residual.evaluate(model->start(), true)->values;
  std::vector<VectorXd> together(16);
  WorkerPool pool(4);
  pool.run(16, [&](int i) { together[std::size_t(i)] = residual.evaluate(model->start(), true)->values; });
  for (const auto& values : together) EXPECT_EQ(values, alone);
}

TEST(ModalResidual, HasNoValueWhereTheModelHasNone) {
  const auto model = twins(900.0);
  const auto places = points({"m0", "m1", "m2", "m3"});
  const ModalResidual residual(model, measurement(*model, model->start(), places, 2), places, model->start());
  VectorXd negative = model->start();
  negative[0] = -2000.0;
  EXPECT_FALSE(residual.evaluate(negative, false));
  VectorXd loose = model->start();
  loose[2] = 0.0;  // f = 0 has no derivative
  EXPECT_FALSE(residual.evaluate(loose, true));
  // a mode that no longer looks like anything measured is lost
  const ModalResidual strict(model, measurement(*model, model->start(), places, 2), places, model->start(),
                             {.lost_mac = 0.99});
  VectorXd bent = model->start();
  bent[1] = 100.0;
  EXPECT_TRUE(residual.evaluate(bent, false));
  EXPECT_FALSE(strict.evaluate(bent, false));
}

TEST(ModalResidual, SaysWhatPairsWithNothing) {
  const auto model = chain();
  const auto places = points(four_places);
  auto measured = measurement(*model, model->start(), places, 3);
  measured[1].shape = Eigen::Vector4d(1.0, -1.0, 1.0, 0.2);
  measured[1].frequency = 2.0;
  const auto message = message_of([&] { ModalResidual(model, measured, places, model->start(), {.modes = 3}); });
  EXPECT_NE(message.find("measured mode 2 (2 Hz) does not pair with any mode"), std::string::npos) << message;
  EXPECT_NE(message.find("MAC"), std::string::npos);
  EXPECT_EQ(message.find("measured mode 1"), std::string::npos);

  const auto two = twins(900.0);
  auto many = measurement(*two, two->start(), points({"m0"}), 4);
  many.push_back(many.back());
  drop_shapes(many);
  EXPECT_NE(message_of([&] { ModalResidual(two, many, {}, two->start()); }).find("there are 4 elastic modes"),
            std::string::npos);
}

TEST(ModalResidual, EverythingWrongIsSaidAtOnce) {
  const auto model = chain();
  const auto places = points(four_places);
  auto measured = measurement(*model, model->start(), places, 3);
  measured[0].deviation = 0.0;
  measured[1].shape.conservativeResize(3);
  measured[2].shape_deviation = -1.0;
  measured[2].model_mode = 0;
  const auto message = message_of([&] { ModalResidual(model, measured, places, model->start()); });
  for (const char* part : {"measured mode 1", "0 Hz", "3 entries", "-1", "numbered from 1"})
    EXPECT_NE(message.find(part), std::string::npos) << part << " in " << message;
  EXPECT_NE(message_of([&] {
              ModalResidual(model, measurement(*model, model->start(), places, 3), points({"m1", "m4", "m6", "tip"}),
                            model->start());
            }).find("'tip'"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
