// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/study/live_plan.hpp"

/// Keys of a stream in the place of a record.
namespace kalfem::wiring {
namespace {

LivePlan plan_of(const std::string& text) {
  return make_live_plan(study_of(estimated_case({{"simulate", ""}, {"live", "{sample_rate: 100 Hz" + text + "}"}})));
}

void rate_and_times() {
  const auto plan = plan_of(", start: 2 s, horizon: 0.5 s, every: 3 s");
  near(plan.problem.problem->sample_rate, 100.0);
  near(plan.start.value(), 2.0);
  EXPECT_FALSE(plan_of("").start.has_value());
  near(plan.options.horizon, 0.5);
  near(plan.every, 3.0);
}

void units_of_the_stream() {
  EXPECT_EQ(plan_of(", unit: mm").channels.at(0).given, "mm");
  EXPECT_EQ(plan_of("").channels.at(0).given, "");
}

void options_of_the_filter() {
  const auto plan = plan_of(", input_delay: 3, window: 700");
  EXPECT_EQ(plan.options.filter.input_delay, 3);
  EXPECT_EQ(plan.options.filter.window, 700);
  EXPECT_TRUE(plan.options.filter.gates.has_value());
  EXPECT_FALSE(plan_of(", gated: false").options.filter.gates.has_value());
}

void gates() {
  const auto found = *plan_of(
                          ", gates: {limit: 5, warm_up: 11, memory: 22, suspend_after: 3, stuck: 4, patience: 55, "
                          "inflation: 6, silence: 77, most_events: 88}")
                          .options.filter.gates;
  near(found.limit, 5.0);
  EXPECT_EQ(found.warm_up, 11);
  EXPECT_EQ(found.memory, 22);
  EXPECT_EQ(found.suspend_after, 3);
  EXPECT_EQ(found.stuck, 4);
  EXPECT_EQ(found.patience, 55);
  near(found.inflation, 6.0);
  EXPECT_EQ(found.silence, 77);
  EXPECT_EQ(found.most_events, 88);
}

void places() {
  const auto plan = plan_of(", state: kept, port: 5001");
  EXPECT_EQ(plan.state.filename(), "kept");
  EXPECT_EQ(plan.port, 5001);
  EXPECT_FALSE(plan_of("").port.has_value());
}

}  // namespace

KeyChecks live_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add("live.", {"sample_rate", "start", "horizon", "every"}, rate_and_times);
  add("live.", {"unit"}, units_of_the_stream);
  add("live.", {"input_delay", "window", "gated"}, options_of_the_filter);
  add("live.gates.",
      {"limit", "warm_up", "memory", "suspend_after", "stuck", "patience", "inflation", "silence", "most_events"},
      gates);
  add("live.", {"state", "port"}, places);
  return keys;
}

}  // namespace kalfem::wiring
