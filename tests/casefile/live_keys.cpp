// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "base/scratch_folder.hpp"
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
  const auto plan = plan_of(", input_delay: 3, window: 700, lag: 40");
  EXPECT_EQ(plan.options.filter.input_delay, 3);
  EXPECT_EQ(plan.options.filter.window, 700);
  EXPECT_EQ(plan.options.filter.lag, 40);
  EXPECT_EQ(plan_of("").options.filter.lag, 0);
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

void alarms() {
  const auto plan = plan_of(
      ", alarms: {window: 30 s, reference: 50, memory: 40, level: 3 %, hysteresis: 0.2, persistence: 3, "
      "false_alarms_every: 100 h, covariates: {warmth: {channel: T, effect: 0.2 %}}}");
  const auto found = *plan.options.filter.changes;
  near(found.window, 30.0);
  EXPECT_EQ(found.reference, 50);
  EXPECT_EQ(found.memory, 40);
  near(found.level, 0.03);
  near(found.hysteresis, 0.2);
  EXPECT_EQ(found.persistence, 3);
  near(found.false_alarms_every, 360'000.0);
  ASSERT_EQ(found.covariates.size(), 1U);
  EXPECT_EQ(found.covariates[0].name, "warmth");
  near(found.covariates[0].effect, 0.002);
  EXPECT_TRUE(
      std::ranges::any_of(plan.channels, [](const auto& each) { return each.column == "T" && each.covariate; }));
  EXPECT_FALSE(plan_of("").options.filter.changes.has_value());
}

void mqtt() {
  const auto found = *plan_of(", mqtt: {broker: mine, port: 2883, client: me, topics: [a/+], publish: out}").mqtt;
  EXPECT_EQ(found.broker, "mine");
  EXPECT_EQ(found.port, 2883);
  EXPECT_EQ(found.client, "me");
  EXPECT_EQ(found.topics, std::vector<std::string>{"a/+"});
  EXPECT_EQ(found.publish, "out");
}

void local_ports() {
  const auto plan = plan_of(", metrics: 9101, page: 9102");
  EXPECT_EQ(plan.metrics, 9101);
  EXPECT_EQ(plan.page, 9102);
  EXPECT_THROW(static_cast<void>(plan_of(", port: 9102, page: 9102")), InvalidInput);
}

void mqtt_files() {
  const ScratchFolder folder("mqtt_keys");
  const std::string file = (folder / "given.txt").string();
  std::ofstream(file) << "me\nsecret\n";
  const auto found = *plan_of(", mqtt: {publish: out, authority: " + file + ", certificate: " + file +
                              ", key: " + file + ", login: " + file + "}")
                          .mqtt;
  for (const auto& each : {found.login, found.authority, found.certificate, found.key})
    EXPECT_EQ(each.filename(), "given.txt");
}

}  // namespace

KeyChecks live_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add("live.", {"sample_rate", "start", "horizon", "every"}, rate_and_times);
  add("live.", {"unit"}, units_of_the_stream);
  add("live.", {"input_delay", "window", "lag", "gated"}, options_of_the_filter);
  add("live.gates.",
      {"limit", "warm_up", "memory", "suspend_after", "stuck", "patience", "inflation", "silence", "most_events"},
      gates);
  add("live.", {"state", "port"}, places);
  add("live.alarms.", {"window", "reference", "memory", "level", "hysteresis", "persistence", "false_alarms_every"},
      alarms);
  add("live.alarms.covariates.*.", {"channel", "effect"}, alarms);
  add("live.", {"metrics", "page"}, local_ports);
  add("live.mqtt.", {"broker", "port", "client", "topics", "publish"}, mqtt);
  add("live.mqtt.", {"login", "authority", "certificate", "key"}, mqtt_files);
  return keys;
}

}  // namespace kalfem::wiring
