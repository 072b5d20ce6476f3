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
  ASSERT_EQ(estimate.events.size(), 1U);
  EXPECT_EQ(estimate.events[0].kind, EventKind::jump);
  EXPECT_EQ(estimate.events[0].channel, "suspension.k");
  EXPECT_TRUE(has_reason(estimate, "parameter_jump"));
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
