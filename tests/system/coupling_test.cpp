// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/coupling.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "system/small_systems.hpp"

namespace kalfem {
namespace {

const std::vector<InputDescription> road{{"road", InputKind::base_displacement, "wheel.ground"}};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Coupling, TwoSubstructuresJoinedByASpringAreTheWholeInOnePiece) {
  const double k = 5e3, c = 12.0;
  const auto split = quarter_chain(3, {{"strut", "wheel.w", "body.1", make_law("linear"), values({k, c})}}, road, 0.0);
  LumpedSubstructure whole{
      .name = "all",
      .masses = {{"w", 1.5}, {"1", 1.0}, {"2", 1.0}, {"3", 1.0}},
      .springs = {
          {"tyre", "ground", "w", 2e4, 4.0}, {"strut", "w", "1", k, c}, {"s2", "1", "2", 3e4}, {"s3", "2", "3", 3e4}}};
  const auto model = assemble(whole);
  const auto& system = split.system();
  const Eigen::VectorXd b = system.connectors[0].deformation;
  // sums of a few stiffnesses of up to 5e4 N/m: rounding
  EXPECT_LT((Eigen::MatrixXd(system.stiffness) + k * b * b.transpose() - Eigen::MatrixXd(model.stiffness)).norm(),
            1e-10);
  EXPECT_LT((Eigen::MatrixXd(system.damping) + c * b * b.transpose() - Eigen::MatrixXd(model.damping)).norm(), 1e-13);
  EXPECT_LT((Eigen::MatrixXd(system.mass) - Eigen::MatrixXd(model.mass)).norm(), 1e-15);  // the same numbers
  EXPECT_EQ(system.inputs[0].value, model.grounds[0].stiffness);
  EXPECT_EQ(system.inputs[0].rate, model.grounds[0].damping);
}

TEST(Coupling, ConnectorToAMovingGroundPullsAsALinearSpringDoes) {
  // -b k (b^T z - g r) must be the one-piece -K z + k_g r, whichever way round the connector is named.
  const double k = 7e3;
  LumpedSubstructure whole{.name = "body", .masses = {{"x", 2.0}}, .springs = {{"s", "ground", "x", 1e3 + k}}};
  const auto expected = assemble(whole).grounds[0].stiffness;
  for (const auto& [from, to] : {std::pair{"body.ground", "body.x"}, std::pair{"body.x", "body.ground"}}) {
    const auto model = oscillator(2.0, 0.0, 1e3, {{"strut", from, to, make_law("linear"), values({k, 0.0})}},
                                  {{"road", InputKind::base_displacement, "body.ground"}});
    const auto& connector = model.system().connectors[0];
    const Eigen::VectorXd pull = model.system().inputs[0].value + k * connector.deformation * connector.base[0];
    EXPECT_NEAR(pull[0], expected[0], 1e-11) << from;  // rounding of 1e4 N/m
  }
}

TEST(Coupling, ConnectorToTheFixedGroundDoesNotFeelTheMovingOne) {
  const auto model = quarter_chain(1,
                                   {{"stay", "ground", "body.1", make_law("linear"), values({1.0, 0.0})},
                                    {"across", "wheel.ground", "ground", make_law("linear"), values({1.0, 0.0})}},
                                   road);
  const auto& [stay, across] = std::pair(model.system().connectors[0], model.system().connectors[1]);
  EXPECT_EQ(stay.deformation, values({0.0, 1.0}));
  EXPECT_EQ(stay.base, values({0.0}));
  EXPECT_EQ(across.deformation, values({0.0, 0.0}));  // d = -r
  EXPECT_EQ(across.base, values({1.0}));
  EXPECT_NE(message_of([&] {
              quarter_chain(1, {{"c", "ground", "body.ground", make_law("linear"), values({1.0, 0.0})}}, road);
            }).find("there is no relative motion between them"),
            std::string::npos);
  EXPECT_THROW((void)model.motion("ground"), InvalidInput);  // no place for a sensor
}

TEST(Coupling, OneInputMovesSeveralGroundsByTheirWeights) {
  LumpedSubstructure beam{.name = "beam",
                          .masses = {{"1", 1.0}, {"2", 1.0}},
                          .springs = {{"l", "left", "1", 100.0, 2.0}, {"r", "right", "2", 300.0, 5.0}},
                          .grounds = {"left", "right"}};
  const CoupledModel model({{"beam", assemble(beam)}},
                           {{"c", "beam.left", "beam.right", make_law("linear"), values({1.0, 0.0})}},
                           {{"quake", InputKind::base_displacement, "", {{"beam.left", 1.0}, {"beam.right", -0.5}}}});
  EXPECT_EQ(model.system().inputs[0].value, values({100.0, -150.0}));
  EXPECT_EQ(model.system().inputs[0].rate, values({2.0, -2.5}));
  EXPECT_EQ(model.motion("beam.right").base, values({-0.5}));
  EXPECT_EQ(model.system().connectors[0].base, values({1.5}));  // d = r_right - r_left = -1.5 r
}

TEST(Coupling, AWholeBaseAcceleratesOnlyWhatFollowsIt) {
  const std::vector<InputDescription> quake{{"quake", InputKind::base_acceleration, ""}};
  LumpedSubstructure lever{
      .name = "lever", .masses = {{"z", 1.0}, {"p", 1.0}}, .points = {{"end", {{"z", 1.0}, {"p", 0.4}}}}};
  const auto free = assemble(lever);
  EXPECT_NE(message_of([&] {
              CoupledModel({{"lever", free}},
                           {{"c", "lever.ground", "lever.end", make_law("linear"), values({1.0, 0.0})}}, quake);
            }).find("accelerating all degrees of freedom equally deforms it"),
            std::string::npos);
  lever.springs = {{"s", "ground", "end", 100.0}};
  EXPECT_NE(message_of([&] {
              CoupledModel({{"lever", assemble(lever)}}, {}, quake);
            }).find("deforms substructure 'lever'"),
            std::string::npos);
  EXPECT_NO_THROW(
      oscillator(1.0, 1.0, 1e3, {{"c", "body.ground", "body.x", make_law("linear"), values({1.0, 0.0})}}, quake));
  EXPECT_NO_THROW(CoupledModel({{"lever", assemble(lever)}}, {},
                               {{"quake", InputKind::base_acceleration, "", {{"lever.z", 1.0}}}}));
}

TEST(Coupling, FiniteElementsFollowAWholeBaseAlongOneAxisOnly) {
  const auto accepted = [](const std::vector<std::string>& dofs) {
    LinearModel model = assemble({.name = "m",
                                  .masses = {{"a", 1.0}, {"b", 1.0}},
                                  .springs = {{"s", "ground", "a", 100.0}, {"t", "a", "b", 50.0}}});
    model.dofs = dofs;
    model.grounds.clear();  // held by supports, whose reactions are no pulls of a ground
    model.points_only = true;
    return message_of([&] { CoupledModel({{"m", model}}, {}, {{"quake", InputKind::base_acceleration, ""}}); }).empty();
  };
  EXPECT_TRUE(accepted({"n1.x", "n2.x"}));
  EXPECT_FALSE(accepted({"n1.x", "n1.y"}));
  EXPECT_FALSE(accepted({"n1.rx", "n2.rx"}));
  EXPECT_FALSE(accepted({"n1.x", "mode1"}));
}

TEST(Coupling, PointsAreFoundByTheirQualifiedNames) {
  LumpedSubstructure bar{.name = "bar",
                         .masses = {{"z", 10.0}, {"p", 2.0}},
                         .springs = {{"s", "ground", "end", 100.0}},
                         .points = {{"end", {{"z", 1.0}, {"p", 0.4}}}}};
  const CoupledModel model({{"bar", assemble(bar)}}, {}, {{"road", InputKind::base_displacement, "bar.ground"}});
  EXPECT_EQ(model.motion("bar.p").dofs, values({0.0, 1.0}));
  EXPECT_EQ(model.motion("bar.end").dofs, values({1.0, 0.4}));
  EXPECT_EQ(model.motion("bar.ground").base, values({1.0}));
  EXPECT_EQ(model.motion("bar.ground").dofs, values({0.0, 0.0}));
  EXPECT_EQ(model.dof_index("bar.p"), 1);
  EXPECT_EQ(model.dof_index("bar.end"), -1);
  EXPECT_NE(message_of([&] { (void)model.motion("bar.ent"); }).find("did you mean 'bar.end'?"), std::string::npos);
}

TEST(Coupling, ForceActsOnACombinationByItsCoefficients) {
  LumpedSubstructure bar{.name = "bar",
                         .masses = {{"z", 10.0}, {"p", 2.0}},
                         .springs = {{"s", "ground", "z", 100.0}},
                         .points = {{"end", {{"z", 1.0}, {"p", 0.4}}}}};
  const CoupledModel model({{"bar", assemble(bar)}}, {}, {{"F", InputKind::force, "bar.end"}});
  EXPECT_EQ(model.system().inputs[0].value, values({1.0, 0.4}));
}

TEST(Coupling, EveryMistakeIsNamedAtOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto build = [&] {
    quarter_chain(2,
                  {{"c1", "wheel.w", "body.one", make_law("linear"), values({1.0, 0.0})},
                   {"c2", "wheel.w", "wheel.w", make_law("linear"), values({1.0, 0.0})},
                   {"c3", "wheel.w", "body.1", make_law("linear"), values({nan, 0.0})},
                   {"c4", "wheel.w", "body.1", make_law("linear"), values({1.0})},
                   {"c5", "wheel.w", "body.1", nullptr, values({1.0})}},
                  {{"r1", InputKind::base_displacement, "wheel.groud"},
                   {"r2", InputKind::force, "wheel.ground"},
                   {"r3", InputKind::force, "body.9"}});
  };
  const auto message = message_of(build);
  for (const char* part : {"connector 'c1'", "connector 'c2'", "connector 'c3'", "connector 'c4'", "connector 'c5'",
                           "did you mean 'wheel.ground'?", "acts on the ground", "body.9"})
    EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
}

TEST(Coupling, DoubledNamesAreRefused) {
  const ConnectorDescription strut{"strut", "wheel.w", "body.1", make_law("linear"), values({1.0, 0.0})};
  EXPECT_NE(message_of([&] { quarter_chain(2, {strut, strut}, road); }).find("strut"), std::string::npos);
  EXPECT_NE(message_of([&] { quarter_chain(2, {}, {road[0], road[0]}); }).find("road"), std::string::npos);
  LumpedSubstructure body{.name = "body", .masses = {{"x", 1.0}}};
  const Substructure part{"body", assemble(body)};
  EXPECT_NE(message_of([&] { CoupledModel({part, part}, {}, {}); }).find("body"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
