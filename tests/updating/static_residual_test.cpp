// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/static_residual.hpp"
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "model/fe_models.hpp"
#include "updating/affine_model.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A cantilever of 1 m, 20 mm wide and 10 mm high.
std::shared_ptr<const AffineModel> cantilever() {
  auto model = beam_model({1.0, 0.0, 0.0}, 8, rectangular_section(0.02, 0.01));
  model.fixed = {{.name = "root", .nodes = {0}}};
  model.springs = {{.name = "prop", .from = {4, 2}, .to = {}, .stiffness = 500.0}};
  return shared(fe_affine_model(model, {"steel.youngs_modulus", "prop.stiffness", "steel.density"}));
}

StaticTest tip_load() {
  return {"tip load", {{{{"n9.z", 1.0}}, 50.0}}, {{{{"n9.z", 1.0}}, 0.1, 1e-3}, {{{"n9.ry", 1.0}}, -0.1, 1e-2}}};
}

TEST(StaticResidual, CantileverHasItsClosedForm) {
  const auto model = cantilever();
  VectorXd parameters = model->start();
  parameters[1] = 1e-6;  // a prop that carries nothing
  const StaticResidual residual(model, {tip_load()}, parameters);
  const double E = 2.1e11, I = 0.02 * std::pow(0.01, 3) / 12.0, G = E / 2.6, A = 2e-4;
  const double cowper = 10.0 * 1.3 / (12.0 + 11.0 * 0.3);  // shear factor of a rectangle [Cow66]
  const double tip = 50.0 / (3.0 * E * I) + 50.0 / (cowper * G * A), slope = -50.0 / (2.0 * E * I);
  const VectorXd u = residual.displacements(parameters);
  // the prop of 1e-6 N/m carries 9e-11 and 7e-11 of it
  EXPECT_NEAR(u[0] / tip, 1.0, 3e-10);
  EXPECT_NEAR(u[1] / slope, 1.0, 3e-10);
  const auto value = residual.evaluate(parameters, false);
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->values[0], (u[0] - 0.1) / 1e-3, 1e-13);  // rounding of values up to 100
  EXPECT_NEAR(value->values[1], (u[1] + 0.1) / 1e-2, 1e-13);
  EXPECT_EQ(value->jacobian.size(), 0);
}

TEST(StaticResidual, JacobianAgreesWithDifferences) {
  const auto model = cantilever();
  const StaticTest pair{
      "couple",
      {{{{"n5.z", 1.0}, {"n9.z", -2.0}}, 30.0}, {{{"n3.y", 1.0}}, 100.0}},
      {{{{"n9.z", 1.0}, {"n5.z", -1.0}}, 0.01, 1e-3}, {{{"n9.y", 1.0}}, 0.0, 1e-4}, {{{"n2.z", 1.0}}, 0.0, 1e-5}}};
  const StaticResidual residual(model, {tip_load(), pair}, model->start());
  EXPECT_EQ(residual.size(), 5);
  const auto value = residual.evaluate(model->start(), true);
  ASSERT_TRUE(value);
  const MatrixXd differences = jacobian_by_differences(
      [&](const VectorXd& at) { return residual.evaluate(at, false)->values; }, model->start(), 1e-2);
  const MatrixXd scaled = value->jacobian * model->start().asDiagonal();
  EXPECT_GT(scaled.col(1).norm(), 1.0);
  // differences of the fourth order with steps of 1 %: found 2e-9
  EXPECT_LT((scaled - differences * model->start().asDiagonal()).norm(), 6e-9 * scaled.norm());
  EXPECT_EQ(scaled.col(2).norm(), 0.0);  // mass carries no static load
}

TEST(StaticResidual, StructureMustBeHeld) {
  const auto chain = shared(spring_model({1.0, 1.0, 1.0}, {{0, 1, 1e3}, {1, 2, 1e3}}));
  const StaticTest test{"pull", {{{{"m0", 1.0}}, 1.0}}, {{{{"m2", 1.0}}, 0.0, 1.0}}};
  const auto message = message_of([&] { StaticResidual(chain, {test}, chain->start()); });
  EXPECT_NE(message.find("free to move"), std::string::npos) << message;

  // a spring of the size of roundings holds nothing, though every pivot is positive
  const auto adrift = shared(spring_model({1.0, 1.0, 1.0}, {{0, 1, 1e3}, {1, 2, 1e3}, {-1, 2, 1e-9}}));
  EXPECT_NE(message_of([&] { StaticResidual(adrift, {test}, adrift->start()); }).find("without strain"),
            std::string::npos);

  auto beam = beam_model({1.0, 0.0, 0.0}, 8, rectangular_section(0.02, 0.01));
  const auto free = shared(fe_affine_model(beam, {"steel.youngs_modulus"}));
  EXPECT_NE(message_of([&] { StaticResidual(free, {tip_load()}, free->start()); }).find("free to move"),
            std::string::npos);
}

TEST(StaticResidual, HasNoValueWhereNothingHolds) {
  const auto chain = shared(spring_model({1.0, 1.0}, {{-1, 0, 1e3}, {0, 1, 1e3}}));
  const StaticTest test{"pull", {{{{"m1", 1.0}}, 1.0}}, {{{{"m1", 1.0}}, 0.0, 1.0}}};
  const StaticResidual residual(chain, {test}, chain->start());
  EXPECT_NEAR(residual.displacements(chain->start())[0], 2e-3, 1e-17);  // rounding
  EXPECT_FALSE(residual.evaluate(Eigen::Vector2d(0.0, 1e3), true));
  EXPECT_FALSE(residual.evaluate(Eigen::Vector2d(1e3, -10.0), true));
}

TEST(StaticResidual, EverythingWrongIsSaidAtOnce) {
  const auto chain = shared(spring_model({1.0, 1.0}, {{-1, 0, 1e3}, {0, 1, 1e3}}));
  const auto empty = message_of([&] { StaticResidual(chain, {{"a", {}, {}}}, chain->start()); });
  EXPECT_NE(empty.find("no forces"), std::string::npos);
  EXPECT_NE(empty.find("no measured displacements"), std::string::npos);
  const StaticTest exact{"b", {{{{"m1", 1.0}}, 1.0}}, {{{{"m1", 1.0}}, 0.0, 0.0}}};
  EXPECT_NE(message_of([&] { StaticResidual(chain, {exact}, chain->start()); }).find("deviation"), std::string::npos);
  const StaticTest nowhere{"c", {{{{"m1", 1.0}}, 1.0}}, {{{{"m7", 1.0}}, 0.0, 1.0}}};
  EXPECT_NE(message_of([&] { StaticResidual(chain, {nowhere}, chain->start()); }).find("'m7'"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
