// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

constexpr double modulus = 210e9, width = 0.02, height = 0.01, area = width * height, gravity = 9.81;
/// About the axes y and z of the section: the beam is wide along its local y.
constexpr double flat = width * height * height * height / 12.0, edge = height * width * width * width / 12.0;

/// A force at the tip along an axis deflects it by F L^3 / (3 E I), its slope by F L^2 / (2 E I).
TEST(Statics, OfACantilever) {
  const auto found = statics(cantilever(), {{.name = "up", .forces = {{.at = "tip", .force = {0.0, 0.0, 10.0}}}},
                                            {.name = "along", .forces = {{.at = "tip", .force = {1000.0, 0.0, 0.0}}}}});
  ASSERT_EQ(found.cases.size(), 2U);
  const auto& up = found.cases[0];
  const auto& tip = up.nodes.at(1);
  EXPECT_EQ(tip.name, "tip");
  const double deflection = tip.displacement[2], inertia = 10.0 / (3.0 * modulus * deflection);
  EXPECT_NEAR(std::min(std::abs(inertia / flat - 1.0), std::abs(inertia / edge - 1.0)), 0.0, 1e-9);
  EXPECT_NEAR(-tip.displacement[4], 1.5 * deflection, 1e-9 * deflection);
  EXPECT_TRUE(up.displacements.col(10) == tip.displacement);
  ASSERT_EQ(up.reactions.size(), 1U);
  EXPECT_EQ(up.reactions[0].name, "root");
  EXPECT_NEAR(up.reactions[0].force.z(), -10.0, 1e-8);
  EXPECT_NEAR(up.reactions[0].moment.y(), 10.0, 1e-8);  // about the root
  EXPECT_LT(up.imbalance, 1e-8);
  const auto& along = found.cases[1];
  EXPECT_NEAR(along.nodes.at(1).displacement[0], 1000.0 / (modulus * area), 1e-9 * 1000.0 / (modulus * area));
  ASSERT_EQ(along.peaks.size(), 1U);
  EXPECT_TRUE(along.peaks[0].of_beam);
  EXPECT_NEAR(along.peaks[0].stress, 1000.0 / area, 1e-6 * 1000.0 / area);
}

/// Its weight, spread over the region, and a node that is moved: the deflection under a uniform load is q L^4 / (8 E
/// I).
TEST(Statics, TakesWeightsRegionsNumbersAndImposedMotions) {
  const double weight = 7850.0 * area * gravity;
  const auto found = statics(cantilever(), {{.name = "weight", .gravity = {0.0, 0.0, -gravity}},
                                            {.name = "spread", .forces = {{.at = "bar", .force = {0.0, 0.0, -weight}}}},
                                            {.name = "number", .forces = {{.at = "11", .force = {0.0, 0.0, -1.0}}}},
                                            {.name = "moved", .displacements = {{"tip.z", 2e-3}}}});
  const auto sag = [&](std::size_t i) { return found.cases[i].nodes.at(1).displacement[2]; };
  const double stiffness = -1.0 / sag(2);  // 3 E I / L^3
  EXPECT_NEAR(sag(0), -weight * 3.0 / (8.0 * stiffness), 1e-9 * std::abs(sag(0)));
  EXPECT_NEAR(found.cases[0].applied.force.z(), -weight, 1e-9 * weight);
  EXPECT_NEAR(found.cases[1].applied.force.z(), -weight, 1e-9 * weight);
  EXPECT_NEAR(sag(1), sag(0), 0.02 * std::abs(sag(0)));  // without the moments of the distributed load
  EXPECT_DOUBLE_EQ(sag(3), 2e-3);
  EXPECT_NEAR(found.cases[3].reaction_sum.force.z(), 0.0, 1e-9);
}

TEST(Statics, RefusesWrongLoadsByTheirPlace) {
  const auto message = refusal_of([] {
    return statics(cantilever(), {{.name = "pull",
                                   .forces = {{.at = "tp"}, {.at = "tip", .force = {0.0, NAN, 0.0}}},
                                   .pressures = {{.on = "bar", .pressure = 1.0}}},
                                  {.name = "pull", .displacements = {{"tip.w", 1.0}}}});
  });
  EXPECT_THAT(message, HasSubstr("cases[0] 'pull': forces[0]: there is no node or group 'tp' (did you mean 'tip'?)"));
  EXPECT_THAT(message, HasSubstr("forces[1]: a component is not finite"));
  EXPECT_THAT(message, HasSubstr("pressures[0]: the group 'bar' holds no faces"));
  EXPECT_THAT(message, HasSubstr("cases[1] 'pull': displacements: there is no motion 'tip.w'"));
  EXPECT_THAT(message, HasSubstr("there are two load cases 'pull'"));
  EXPECT_THAT(refusal_of([] { return statics(cantilever(), {}); }), HasSubstr("cases: the list is empty"));
}

}  // namespace
}  // namespace kalfem
