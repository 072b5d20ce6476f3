// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

namespace kalfem {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(Structure, NamesItsPointsAndParameters) {
  const Structure s = chain_structure();
  EXPECT_THAT(s.points(), Contains("wheel.w"));
  EXPECT_THAT(s.points(), Contains("body.4"));
  EXPECT_THAT(s.parameters(), Contains("suspension.mu_k1"));
  EXPECT_THAT(s.parameters(), Contains("body.3-4.stiffness"));
  EXPECT_EQ(s.value("suspension.mu_k1"), 20.0);
  EXPECT_EQ(s.value("body.2.mass"), 1.0);
}

TEST(Structure, AtOtherValuesIsAnotherStructure) {
  const Structure s = chain_structure();
  const Structure moved = s.at({{"suspension.mu_k1", 15.0}, {"body.2-3.stiffness", 2e4}});
  EXPECT_EQ(moved.value("suspension.mu_k1"), 15.0);
  EXPECT_EQ(moved.value("body.2-3.stiffness"), 2e4);
  EXPECT_EQ(s.value("suspension.mu_k1"), 20.0);
}

TEST(Structure, TakesSamplesWithTheirRateAndMakesTheirDerivatives) {
  const double rate = 1000.0;
  const auto samples = road()->sample(0.0, 1.0 / rate, 2001);
  const Structure sampled =
      chain_structure().base_displacement("road", "wheel.ground", {samples.col(0).matrix(), rate});
  const auto record = simulate(sampled, {.sensors = chain_sensors(), .duration = 1.9, .sample_rate = 500.0}).record;
  const auto exact =
      simulate(driven_chain(), {.sensors = chain_sensors(), .duration = 1.9, .sample_rate = 500.0}).record;
  EXPECT_LT(nrmse(record.values.row(0).transpose(), exact.values.row(0).transpose()), 2e-3);
}

TEST(Structure, OneMassOnASpringMovesAsTheClosedFormSays) {
  // A constant force on an oscillator at rest: x = f / k (1 - cos(omega t)).
  Structure s;
  s.add(lumped("oscillator").mass("m", 2.0).spring("k", "ground", "m", 800.0));
  s.force("push", "oscillator.m", {Eigen::VectorXd::Constant(11, 8.0), 10.0});
  const auto record =
      simulate(s, {.sensors = {{"x", displacement("oscillator.m")}}, .duration = 1.0, .sample_rate = 100.0}).record;
  for (Eigen::Index k = 0; k < record.samples(); ++k)
    EXPECT_NEAR(record.values(0, k), 0.01 * (1.0 - std::cos(20.0 * record.time(k))), 1e-12);
}

TEST(Structure, WhatDoesNotFitIsReportedTogether) {
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "v", 2e4));
  EXPECT_THAT(refusal_of([&] { return s.parameters(); }), HasSubstr("'v'"));
  Structure other = chain_structure();
  other.connect("mount", "wheel.x", "body.1", suspension_law(1.0));
  other.connect("stop", "wheel.w", "body.7", suspension_law(1.0));
  const auto message = refusal_of([&] { return other.points(); });
  EXPECT_THAT(message, HasSubstr("wheel.x"));
  EXPECT_THAT(message, HasSubstr("body.7"));
}

TEST(Structure, WrongArgumentsAreNamed) {
  EXPECT_THAT(refusal_of([] { return chain("body", 0, 1.0, 3e4); }), HasSubstr("chain 'body' has 0 masses"));
  EXPECT_THAT(refusal_of([] { return chain_structure().connect("mount", "wheel.w", "body.1", Law{}); }),
              HasSubstr("connector 'mount' has no law"));
  EXPECT_THAT(refusal_of([] {
                return chain_structure().force("push", "body.1", {Eigen::VectorXd::Zero(1), 10.0});
              }),
              HasSubstr("input 'push': "));
  EXPECT_THAT(refusal_of([] {
                return chain_structure().at({{"suspension.mu_k9", 1.0}});
              }),
              HasSubstr("at 'suspension.mu_k9': there is no parameter of that name"));
  EXPECT_THAT(refusal_of([] { return channel(chain_record(), "a4"); }), HasSubstr("the record has no channel 'a4'"));
}

}  // namespace
}  // namespace kalfem
