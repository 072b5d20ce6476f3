// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

TEST(InitialState, IsRestWhereNothingIsNamed) {
  const CoupledModel model = couple(chain_parts());
  const auto start = initial_state({}, model);
  EXPECT_EQ(start.displacement, Eigen::VectorXd::Zero(11));
  EXPECT_EQ(start.velocity, Eigen::VectorXd::Zero(11));
  EXPECT_EQ(start.connector_states.size(), 0);
}

TEST(InitialState, StandsAtTheDegreesOfFreedomThatAreNamed) {
  const CoupledModel model = couple(chain_parts());
  const auto start = initial_state({{"wheel.w", {{0.01, -0.2}}}, {"body.10", {{0.0, 0.3}}}}, model);
  EXPECT_EQ(start.displacement[0], 0.01);
  EXPECT_EQ(start.velocity[0], -0.2);
  EXPECT_EQ(start.velocity[10], 0.3);
  EXPECT_EQ(start.displacement.tail(10).norm() + start.velocity.segment(1, 9).norm(), 0.0);
}

TEST(InitialState, LetsAnOscillatorRingInItsClosedForm) {
  StructureParts parts;
  parts.substructures = {chain_wheel()};
  const CoupledModel model = couple(parts);
  const auto result =
      simulate(model.system(), {}, initial_state({{"wheel.w", {{0.01, 0.5}}}}, model), {.step = 1e-3, .duration = 0.1});
  const double omega = std::sqrt(wheel_stiffness / 1.5), t = 0.1;
  EXPECT_NEAR(result.trajectory.displacement(0, 100), 0.01 * std::cos(omega * t) + 0.5 / omega * std::sin(omega * t),
              1e-12);
}

TEST(InitialState, OfAPointThatIsNoneIsRefusedWithItsPlace) {
  const CoupledModel model = couple(chain_parts());
  const std::string text = refusal([&] {
    initial_state({{"body.12", {{0.1, 0.0}, {"chain.yaml", 7}, "simulate.initial"}}}, model);
  });
  EXPECT_NE(text.find("chain.yaml:7"), std::string::npos) << text;
  EXPECT_NE(text.find("simulate.initial: 'body.12' is not a degree of freedom"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean 'body.1"), std::string::npos) << text;
}

}  // namespace
}  // namespace kalfem::test
