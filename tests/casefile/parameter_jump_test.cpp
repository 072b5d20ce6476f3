// SPDX-License-Identifier: Apache-2.0
#include "casefile/changing_chain.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/diagnosis/look_for_cause.hpp"

// A constant that changes within the record: found with its time and size, and not where nothing changes.

namespace kalfem::test {
namespace {

bool has_reason(const RecordEstimate& estimate, const std::string& code) {
  return std::ranges::any_of(verdict_of(estimate).reasons(), [&](const Reason& each) { return each.code == code; });
}

TEST(ParameterJump, IsFoundWithItsTimeAndSize) {
  const auto estimate = estimate_of(steady_chain(1, 8.0), dropping_chain(1, 8.0, 4.0));
  ASSERT_TRUE(estimate.jump.has_value());
  const auto& jump = *estimate.jump;
  EXPECT_EQ(estimate.augmented_model->options().unknowns[static_cast<std::size_t>(jump.unknown)].name, "suspension.k");
  EXPECT_NEAR(estimate.measurements.time(jump.sample), 4.0, 0.1);
  EXPECT_NEAR(jump.after / jump.before, 0.8, 0.03);
  EXPECT_NEAR(jump.after - jump.before, -1e3, 4.0 * jump.deviation);
  EXPECT_TRUE(jump.explains);
  EXPECT_LE(estimate.measurements.time(jump.earliest), 4.0);
  EXPECT_GE(estimate.measurements.time(jump.latest), 4.0);
  EXPECT_LT(jump.latest - jump.earliest, 200);
  ASSERT_EQ(estimate.events.size(), 1U);
  EXPECT_EQ(estimate.events[0].kind, EventKind::jump);
  EXPECT_EQ(estimate.events[0].channel, "suspension.k");
  EXPECT_TRUE(has_reason(estimate, "parameter_jump"));
}

/// Three masses whose second spring falls by a third halfway, little damped: the estimates of a model that holds it
/// constant suit neither half, and their scores hint at another spring.
std::string sprung_masses(const std::string& factor, const std::string& signals) {
  return R"(kalfem: 1
substructures: {m: {masses: {a: 10 kg, b: 8 kg, c: 12 kg}}}
connectors:
  s1: {from: ground, to: m.a, law: linear, parameters: {k: 40 kN/m, c: 15 N s/m}}
  s2:
    from: m.a
    to: m.b
    law: expression
    force: k*)" +
         factor + R"(*x + c*v
    parameters: {k: 50 kN/m, c: 15 N s/m}
)" + signals +
         R"(  s3: {from: m.b, to: m.c, law: linear, parameters: {k: 30 kN/m, c: 15 N s/m}}
excitation: {f: {force: m.c, random: {rms: 100 N, band: [1 Hz, 30 Hz], seed: 3}}}
sensors: {a: {acceleration: m.a, noise: 5 %}, b: {acceleration: m.b, noise: 5 %}, c: {acceleration: m.c, noise: 5 %}}
simulate: {duration: 20 s, sample_rate: 200 Hz, seed: 3}
estimate: {second_thoughts: 2, unknown: {s1.k: {initial: 36 kN/m, std: 30 %}, s2.k: {initial: 45 kN/m, std: 30 %}, s3.k: {initial: 33 kN/m, std: 30 %}}}
)";
}

TEST(ParameterJump, IsTheFirstReasonWithinTwoAnswers) {
  const Study simulated =
      study_of(sprung_masses("(1 - 0.33*min(1, max(0, 200*(t - 10))))", "    signals: {t: time}\n"));
  const Study study = study_of(sprung_masses("1", ""));
  auto setup = *study.augmented_model;
  const auto estimate =
      estimate_record_thoroughly(study.problem, setup, record_of(simulated, run_study(simulated, "simulate")));
  ASSERT_TRUE(estimate.jump.has_value());
  const auto reasons = verdict_of(estimate).reasons();
  EXPECT_EQ(reasons.front().code, "parameter_jump");
  EXPECT_EQ(reasons.front().subject, "s2.k");
  EXPECT_EQ(reasons.front().state, VerdictState::unusable);
  EXPECT_LE(estimate.measurements.time(estimate.jump->earliest), 10.0);
  EXPECT_GE(estimate.measurements.time(estimate.jump->latest), 10.0);
  EXPECT_LT(estimate.measurements.time(estimate.jump->latest) - estimate.measurements.time(estimate.jump->earliest),
            1.0);
}

TEST(ParameterJump, IsNotSeenInAConstant) {
  const auto estimate = estimate_of(steady_chain(2, 8.0), steady_chain(2, 8.0));
  EXPECT_FALSE(estimate.jump.has_value());
  EXPECT_FALSE(has_reason(estimate, "parameter_jump"));
}

/// A wrong law is no change: its error goes on as long as the record does.
TEST(ParameterJump, DoesNotExplainAWrongLaw) {
  std::string linear = steady_chain(3, 8.0);
  linear = changed(linear, "k*1*x + mu*x/(2e-3 + abs(x))", "k*1*x + mu*x/1e-2");
  const auto estimate = estimate_of(linear, steady_chain(3, 8.0));
  EXPECT_FALSE(estimate.jump.has_value() && estimate.jump->explains);
}

}  // namespace
}  // namespace kalfem::test
