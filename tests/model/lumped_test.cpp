// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/lumped.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numbers>

namespace kalfem {
namespace {

/// Two masses between two grounds: ground - k - a - k_middle - b - k - ground.
LumpedSubstructure pair_between_grounds(double mass, double k, double k_middle) {
  return {.name = "pair",
          .masses = {{"a", mass}, {"b", mass}},
          .springs = {{"left", "ground", "a", k}, {"middle", "a", "b", k_middle}, {"right", "b", "ground", k}}};
}

std::string problems_of(const LumpedSubstructure& substructure) {
  std::string all;
  for (const auto& issue : validate(substructure)) all += to_string(issue) + "\n";
  return all;
}

/// Relative; found up to 2e-16.
constexpr double rounding = 3e-15;

TEST(Lumped, FrequenciesOfTwoMassesHaveTheirClosedForm) {
  const double m = 2.0, k = 3e3, k_middle = 5e2;
  const auto model = assemble(pair_between_grounds(m, k, k_middle));
  const auto modes = normal_modes(model.mass, model.stiffness);
  // In phase the middle spring is idle, in opposition it counts twice. Eigensolver rounding only.
  EXPECT_NEAR(2 * M_PI * modes.frequencies[0], std::sqrt(k / m), rounding * std::sqrt(k / m));
  EXPECT_NEAR(2 * M_PI * modes.frequencies[1], std::sqrt((k + 2 * k_middle) / m), rounding * std::sqrt(k / m));
  EXPECT_LT((modes.shapes.transpose() * (model.mass * modes.shapes) - Eigen::Matrix2d::Identity()).norm(), rounding);
}

TEST(Lumped, FreeSubstructureHasAnExactlyZeroFrequency) {
  LumpedSubstructure free{.name = "free", .masses = {{"a", 1.0}, {"b", 3.0}}, .springs = {{"s", "a", "b", 6.0}}};
  const auto model = assemble(free);
  const auto modes = normal_modes(model.mass, model.stiffness);
  EXPECT_EQ(modes.frequencies[0], 0.0);
  EXPECT_NEAR(2 * M_PI * modes.frequencies[1], std::sqrt(6.0 * (1.0 / 1.0 + 1.0 / 3.0)), 2 * rounding);
}

TEST(Lumped, ModalDampingRatiosComeBackFromTheDampingMatrix) {
  auto pair = pair_between_grounds(1.5, 2e4, 3e4);
  pair.masses[1].mass = 4.0;
  pair.modal_damping = {0.01, 0.03};
  const auto model = assemble(pair);
  const auto modes = normal_modes(model.mass, model.stiffness);
  const Eigen::MatrixXd modal = modes.shapes.transpose() * (model.damping * modes.shapes);
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(modal(i, i) / (4 * M_PI * modes.frequencies[i]), pair.modal_damping[std::size_t(i)], rounding * 0.05);
  EXPECT_NEAR(modal(0, 1), 0.0, rounding * modal(1, 1));
}

TEST(Lumped, LastModalRatioHoldsForTheFurtherModes) {
  auto one = pair_between_grounds(1.0, 1e3, 1e3), two = one;
  one.modal_damping = {0.02};
  two.modal_damping = {0.02, 0.02};
  // the same computation, of a rate of 10
  EXPECT_LT((Eigen::MatrixXd(assemble(one).damping) - Eigen::MatrixXd(assemble(two).damping)).norm(), 10 * rounding);
}

TEST(Lumped, RayleighAndDashpotsAddUp) {
  auto pair = pair_between_grounds(2.0, 1e3, 4e2);
  pair.rayleigh = {.mass_factor = 0.7, .stiffness_factor = 1e-3};
  pair.springs[1].damping = 5.0;
  const auto model = assemble(pair);
  const Eigen::Matrix2d dashpot{{5.0, -5.0}, {-5.0, 5.0}};
  const Eigen::Matrix2d expected =
      0.7 * Eigen::MatrixXd(model.mass) + 1e-3 * Eigen::MatrixXd(model.stiffness) + dashpot;
  EXPECT_LT((Eigen::MatrixXd(model.damping) - expected).norm(), 10 * rounding);
}

TEST(Lumped, RigidMotionWithAllGroundsGivesNoForce) {
  LumpedSubstructure body{.name = "body",
                          .masses = {{"a", 1.0}, {"b", 2.0}, {"c", 3.0}},
                          .springs = {{"1", "floor", "a", 1e4, 3.0},
                                      {"2", "b", "a", 2e4, 1.0},
                                      {"3", "b", "c", 5e3, 0.0},
                                      {"4", "c", "wall", 7e3, 8.0}},
                          .grounds = {"floor", "wall"},
                          .modal_damping = {0.05}};
  const auto model = assemble(body);
  ASSERT_EQ(model.grounds.size(), 2u);
  const Eigen::Vector3d ones = Eigen::Vector3d::Ones();
  const Eigen::VectorXd pull = model.grounds[0].stiffness + model.grounds[1].stiffness;
  const Eigen::VectorXd cross_damping = model.grounds[0].damping + model.grounds[1].damping;
  EXPECT_LT((model.stiffness * ones - pull).norm(), 1e-11);         // rounding of 1e4
  EXPECT_LT((model.damping * ones - cross_damping).norm(), 3e-14);  // of 10
  EXPECT_DOUBLE_EQ(model.grounds[0].stiffness[0], 1e4);             // a ground that rises pulls its mass up
  EXPECT_DOUBLE_EQ(model.grounds[1].stiffness[2], 7e3);
}

TEST(Lumped, QuasiStaticFollowingOfOneGroundMeetsNoMaterialDamping) {
  // One of two grounds moves slowly: z = K^-1 k_g r. Modal damping acts on the motion relative to that shape.
  auto pair = pair_between_grounds(1.0, 1e3, 1e3);
  pair.grounds = {"ground", "moving"};
  pair.springs[0].from = "moving";
  pair.modal_damping = {0.1};
  const auto model = assemble(pair);
  const Eigen::MatrixXd stiffness(model.stiffness);
  const auto& moving = model.grounds[1];
  ASSERT_EQ(moving.ground, "moving");
  const Eigen::VectorXd shape = stiffness.ldlt().solve(moving.stiffness);
  EXPECT_NEAR(shape[0], 2.0 / 3.0, rounding);                         // three equal springs in series
  EXPECT_LT((model.damping * shape - moving.damping).norm(), 1e-14);  // rounding of 10
}

TEST(Lumped, SpringsMayEndAtCombinationsOfDegreesOfFreedom) {
  // A bar (heave z, pitch p) on a spring at a = 0.4 m: K = k [1 a; a a^2].
  LumpedSubstructure bar{.name = "bar",
                         .masses = {{"z", 10.0}, {"p", 2.0}},
                         .springs = {{"s", "ground", "end", 100.0, 7.0}},
                         .points = {{"end", {{"z", 1.0}, {"p", 0.4}}}}};
  const auto model = assemble(bar);
  const Eigen::Matrix2d shape{{1.0, 0.4}, {0.4, 0.16}};
  EXPECT_LT((Eigen::MatrixXd(model.stiffness) - 100.0 * shape).norm(), 1e-13);  // rounding of 100 and 7
  EXPECT_LT((Eigen::MatrixXd(model.damping) - 7.0 * shape).norm(), 1e-14);
  EXPECT_LT((model.grounds[0].stiffness - Eigen::Vector2d(100.0, 40.0)).norm(), 1e-13);
  EXPECT_EQ(model.points.at("end").at("p"), 0.4);
}

TEST(Lumped, EveryMistakeIsNamedAtOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  LumpedSubstructure wrong{.name = "body",
                           .masses = {{"a", -1.0}, {"b", nan}, {"b", infinity}, {"wheel", 0.0}},
                           .springs = {{"s1", "a", "wheal", 1.0},
                                       {"s2", "a", "a", 1.0},
                                       {"s3", "a", "b", -5.0},
                                       {"s4", "a", "b", 1.0, nan},
                                       {"s5", "a", "b", infinity}},
                           .points = {{"p", {{"q", 1.0}}}},
                           .modal_damping = {1.5, nan},
                           .rayleigh = {-1.0, 0.0}};
  const auto issues = problems_of(wrong);
  for (const char* part : {"'body.a' is -1", "'body.b' is given twice", "'body.wheel' is 0", "did you mean 'wheel'",
                           "joins 'a' to itself", "'body.s3' has the value -5", "'body.s4' has the value",
                           "'body.s5' has the value inf", "point 'body.p' uses 'q'", "modal damping ratio", "Rayleigh"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
  EXPECT_THROW(assemble(wrong), InvalidInput);
}

TEST(Lumped, DoubledNamesOfPointsAndGroundsAndBadCoefficientsAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LumpedSubstructure wrong{.name = "body",
                           .masses = {{"a", 1.0}, {"ground", 1.0}},
                           .springs = {{"s", "ground", "a", 1.0}},
                           .points = {{"a", {{"a", 2.0}}}, {"p", {{"a", nan}}}}};
  const auto issues = problems_of(wrong);
  for (const char* part : {"'body.ground'", "'body.a'", "coefficient"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
}

TEST(Lumped, WithoutMassesItIsAPlaceForGrounds) {
  LumpedSubstructure place;
  place.name = "road";
  place.grounds = {"front", "rear"};
  place.modal_damping = {0.01};
  const auto model = assemble(place);
  EXPECT_EQ(model.size(), 0);
  EXPECT_EQ(model.grounds.size(), 2u);
  EXPECT_EQ(model.grounds[1].stiffness.size(), 0);
}

/// Two free masses whose stiffness is a little off, as the reduction of a large model leaves it. The root of 5e-14
/// would damp the free motion at a rate of 1e-4, and a damped free motion is no longer a mode of its own.
TEST(NormalModes, WhatRoundingLeavesOfAFreeMotionIsNotDamped) {
  SparseMatrix mass(2, 2), stiffness(2, 2);
  mass.setIdentity();
  for (const double off : {5e-14, -5e-14}) {
    stiffness = Eigen::MatrixXd{{5e7 * (1.0 + 2.0 * off), -5e7}, {-5e7, 5e7}}.sparseView();
    const auto modes = normal_modes(mass, stiffness);
    EXPECT_EQ(modes.frequencies[0], 0.0);
    EXPECT_LT((modal_damping(mass, modes, {0.01}) * Eigen::Vector2d::Ones()).norm(), 1e-10);
  }
  stiffness.coeffRef(0, 0) = 5e7 + 1.0;  // a soft spring to the ground is no rounding
  EXPECT_NEAR(normal_modes(mass, stiffness).frequencies[0], std::sqrt(0.5) / (2.0 * std::numbers::pi), 1e-6);
}

TEST(NormalModes, MasslessDegreeOfFreedomIsRefused) {
  SparseMatrix mass(2, 2), stiffness(2, 2);
  mass.insert(0, 0) = 1.0;
  stiffness.insert(0, 0) = 1.0;
  stiffness.insert(1, 1) = 1.0;
  EXPECT_THROW(normal_modes(mass, stiffness), InvalidInput);
}

TEST(Lumped, MatricesStandBesideMassesAndSprings) {
  const auto by_springs = assemble(pair_between_grounds(2.0, 3e3, 5e2));
  LumpedSubstructure mixed{.name = "pair", .springs = {{"right", "b", "ground", 3e3}}};
  Eigen::Matrix2d mass = 2.0 * Eigen::Matrix2d::Identity(), stiffness;
  stiffness << 3.5e3, -5e2, -5e2, 5e2;
  mixed.matrices = {{"a", "b"}, mass.sparseView(), {}, stiffness.sparseView()};
  mixed.masses = {{"c", 7.0}};
  mixed.springs.push_back({"rod", "b", "c", 11.0});
  const auto model = assemble(mixed);
  ASSERT_EQ(model.dofs, (std::vector<std::string>{"a", "b", "c"}));
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected.topLeftCorner<2, 2>() = Eigen::MatrixXd(by_springs.stiffness);
  expected.bottomRightCorner<2, 2>() += 11.0 * (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
  EXPECT_TRUE(Eigen::MatrixXd(model.stiffness).isApprox(expected, 1e-15));
  EXPECT_EQ(Eigen::MatrixXd(model.mass), Eigen::MatrixXd(Eigen::Vector3d(2.0, 2.0, 7.0).asDiagonal()));
}

TEST(Lumped, MatricesThatDoNotFitAreRefused) {
  LumpedSubstructure part{.name = "p"};
  Eigen::Matrix2d skew, mass = Eigen::Matrix2d::Identity();
  skew << 1, 2, -2, 1;
  part.matrices = {{"a"}, mass.sparseView(), {}, skew.sparseView()};
  EXPECT_NE(problems_of(part).find("M of 'p' is 2 x 2, with 1 names"), std::string::npos) << problems_of(part);
  part.matrices.dofs = {"a", "b"};
  EXPECT_NE(problems_of(part).find("K of 'p' is not symmetric"), std::string::npos) << problems_of(part);
  part.matrices = {{"a"}, {}, {}, Eigen::MatrixXd::Identity(1, 1).sparseView()};
  EXPECT_NE(problems_of(part).find("M of 'p' is missing"), std::string::npos) << problems_of(part);
}

}  // namespace
}  // namespace kalfem
