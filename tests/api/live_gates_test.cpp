// SPDX-License-Identifier: Apache-2.0
// What a filter with gates does with sensors that lie, and what it leaves alone.
#include <random>

#include "quarter_car.hpp"

namespace kalfem::quarter_car {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index per_second = 500;
const OnlineOptions gated{.gates = GateOptions{}};

std::vector<FilterEvent> events_of(LiveFilter& live, FilterEventKind kind, const std::string& channel = "") {
  std::vector<FilterEvent> found;
  for (const auto& event : live.filter().events())
    if (event.kind == kind && (channel.empty() || event.channel == channel)) found.push_back(event);
  return found;
}

double off(LiveFilter& live, double truth = 3e6) {
  const auto k3 = live.filter().parameter("strut.k3");
  return std::abs(k3.mean - truth) / k3.std;
}

std::string told(LiveFilter& live) {
  std::string text;
  for (const auto& event : live.filter().events())
    text += std::to_string(event.time) + " " + to_string(event.kind) + " " + event.channel + ": " + event.text + "\n";
  return text;
}

/// Samples of a part of a record.
auto part(Record& record, Index row, double from, double to) {
  return record.values.row(row).segment(Index(from * rate), Index((to - from) * rate));
}

TEST(LiveGates, ChangeNoBitOfACleanStream) {
  const auto road = road_of(60.0);
  const Record record = drive(60.0, road);
  LiveFilter with = after(record, road, gated), without = after(record, road);
  EXPECT_TRUE(with.filter().events().empty()) << told(with);
  EXPECT_EQ(with.filter().parameter("strut.k3").mean, without.filter().parameter("strut.k3").mean);
  EXPECT_EQ(with.filter().parameter("strut.k3").std, without.filter().parameter("strut.k3").std);
  EXPECT_EQ(with.filter().nis(), without.filter().nis());
  EXPECT_EQ(with.filter().condition(), FilterCondition::consistent);
}

TEST(LiveGates, LeaveOutASensorThatReadsZero) {
  const auto road = road_of(100.0);
  const Record clean = drive(100.0, road);
  for (const Index row : {0, 1}) {
    Record record = clean;
    part(record, row, 30.0, 70.0).setZero();
    LiveFilter live = after(record, road, gated);
    EXPECT_LT(off(live), 3.0) << told(live);
    const auto stuck = events_of(live, FilterEventKind::stuck, sensors[std::size_t(row)].name);
    ASSERT_EQ(stuck.size(), 1U) << told(live);
    EXPECT_NEAR(stuck[0].time, 30.0, 0.2);
    const auto back = events_of(live, FilterEventKind::back);
    ASSERT_EQ(back.size(), 1U) << told(live);
    EXPECT_NEAR(back[0].time, 70.2, 0.5);
    EXPECT_THAT(back[0].text, testing::HasSubstr("again"));
    LiveFilter before = after(record, road);
    EXPECT_GT(off(before), 50.0);  // what the same stream does without gates
    RecordProperty(sensors[std::size_t(row)].name,
                   std::to_string(off(live)) + " deviations off, " + std::to_string(off(before)) + " without gates");
  }
}

TEST(LiveGates, LeaveOutSpikesOneByOne) {
  const auto road = road_of(40.0);
  Record record = drive(40.0, road);
  for (Index k = 5 * per_second; k < record.samples(); k += 400) record.values(k % 2, k) += 30.0;
  LiveFilter live = after(record, road, gated);
  const auto spikes = events_of(live, FilterEventKind::spike);
  EXPECT_EQ(std::ssize(spikes), (record.samples() - 5 * per_second + 399) / 400) << told(live);
  EXPECT_TRUE(events_of(live, FilterEventKind::off).empty()) << told(live);
  EXPECT_LT(off(live), 3.0);
  EXPECT_EQ(live.filter().condition(), FilterCondition::consistent);
}

TEST(LiveGates, NameASensorThatGivesNoiseAlone) {
  const auto road = road_of(60.0);
  Record record = drive(60.0, road);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, sensors[1].noise);
  for (double& value : part(record, 1, 20.0, 40.0).reshaped()) value = noise(random);
  LiveFilter live = after(record, road, gated);
  EXPECT_EQ(events_of(live, FilterEventKind::dead, "body").size(), 1U) << told(live);
  EXPECT_EQ(events_of(live, FilterEventKind::back, "body").size(), 1U) << told(live);
  EXPECT_LT(off(live), 3.0);
}

TEST(LiveGates, NameASensorThatSaturates) {
  const auto road = road_of(40.0);
  Record record = drive(40.0, road);
  const double most = 0.7 * record.values.row(1).maxCoeff();
  record.values.row(1) = record.values.row(1).cwiseMin(most).eval();
  LiveFilter live = after(record, road, gated);
  EXPECT_GE(events_of(live, FilterEventKind::saturated, "body").size(), 1U) << told(live);
  EXPECT_LT(off(live), 3.0);
}

TEST(LiveGates, NameASensorWithAnOffset) {
  const auto road = road_of(60.0);
  Record record = drive(60.0, road);
  part(record, 1, 20.0, 40.0).array() += 1.0;
  LiveFilter live = after(record, road, gated);
  EXPECT_EQ(events_of(live, FilterEventKind::off, "body").size(), 1U) << told(live);
  EXPECT_EQ(events_of(live, FilterEventKind::back, "body").size(), 1U) << told(live);
  EXPECT_TRUE(events_of(live, FilterEventKind::inflated).empty()) << told(live);
  EXPECT_LT(off(live), 3.0);
}

TEST(LiveGates, TellGapsAndSilence) {
  const auto road = road_of(30.0);
  Record record = drive(30.0, road);
  part(record, 0, 10.0, 12.0).setConstant(std::nan(""));
  record.values.rightCols(2 * per_second).setConstant(std::nan(""));
  LiveFilter live = after(record, road, gated);
  const auto missing = events_of(live, FilterEventKind::missing);
  ASSERT_EQ(missing.size(), 3U) << told(live);
  EXPECT_EQ(missing[0].channel, "wheel");
  EXPECT_NEAR(missing[0].time, 10.2, 0.01);  // after GateOptions::silence samples
  EXPECT_EQ(events_of(live, FilterEventKind::back, "wheel").size(), 1U);
  EXPECT_EQ(live.filter().condition(), FilterCondition::silent);
  EXPECT_LT(off(live), 3.0);
}

TEST(LiveGates, LetTheFilterLearnAgainWhereTheStructureHasChanged) {
  const auto road = road_of(120.0);
  const Record before = drive(120.0, road);
  const Record later = simulate(structure(4e6).base_displacement("road", "wheel.ground", road),
                                {.sensors = sensors, .duration = 120.0, .sample_rate = rate, .seed = 3})
                           .record;
  Record record = before;
  record.values.rightCols(80 * per_second) = later.values.rightCols(80 * per_second);
  LiveFilter live = after(record, road, gated), trusting = after(record, road);
  EXPECT_GE(events_of(live, FilterEventKind::inflated).size(), 1U) << told(live);
  EXPECT_LT(off(live, 4e6), 3.0) << told(live);
  EXPECT_GT(off(trusting, 4e6), 10.0);  // it keeps what it learned before
}

TEST(LiveGates, BeginAnewAfterWhatNoModelExplains) {
  GateOptions options{.patience = 200};
  const auto road = road_of(60.0);
  Record record = drive(60.0, road);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 5.0);
  for (const Index row : {0, 1})  // for ten seconds
    for (double& value : part(record, row, 20.0, 30.0).reshaped()) value = noise(random);
  LiveFilter live = after(record, road, {.gates = options});
  EXPECT_GE(events_of(live, FilterEventKind::restarted).size(), 1U) << told(live);
  EXPECT_LT(off(live), 3.0) << told(live);
  EXPECT_TRUE(live.filter().usable());
}

TEST(LiveGates, KeepTheLatestEventsOnly) {
  const auto road = road_of(20.0);
  Record record = drive(20.0, road);
  for (Index k = 3 * per_second; k < record.samples(); k += 200) record.values(0, k) += 50.0;
  LiveFilter live = after(record, road, {.gates = GateOptions{.most_events = 7}});
  EXPECT_EQ(live.filter().events().size(), 7U);
}

/// At a limit of 3 one value in 370 is left out by chance: the rate of normal innovations.
TEST(LiveGates, LeaveOutByChanceWhatTheLimitSays) {
  double left_out = 0.0, values = 0.0;
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const auto road = make_random({.rms = 8e-3, .lower = 0.5, .upper = 12.0, .duration = 40.0, .seed = seed});
    const Record record = drive(40.0, road);
    LiveFilter live =
        after(record, road, {.gates = GateOptions{.limit = 3.0, .suspend_after = 50, .most_events = 10000}});
    left_out += static_cast<double>(events_of(live, FilterEventKind::spike).size());
    values += 2.0 * static_cast<double>(record.samples() - 1000);
  }
  // 320 are expected in 118,000; four deviations of a Poisson count, 20 % for what leaving them out does to the rest
  EXPECT_NEAR(left_out, 0.0027 * values, 4.0 * std::sqrt(0.0027 * values) + 0.2 * 0.0027 * values);
}

TEST(LiveGates, HoldWhatNoSampleTellsOf) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  const Index samples = 120 * per_second;
  const auto deviation_after_rest = [&](const OnlineOptions& online) {
    LiveFilter live(structure(3e6).base_displacement("road", "wheel.ground"), rate,
                    {.sensors = sensors, .unknowns = {{"strut.k1", {.std = 1e3, .random_walk = 300.0}}}},
                    {.filter = online});
    for (Index first = 0; first < samples; first += per_second) {
      const double time = static_cast<double>(first) / rate;
      live.push("road", time, VectorXd::Zero(per_second));
      live.push("wheel", time, VectorXd::NullaryExpr(per_second, [&] { return 0.05 * normal(random); }));
      live.push("body", time, VectorXd::NullaryExpr(per_second, [&] { return 0.02 * normal(random); }));
    }
    const auto k1 = live.filter().parameter("strut.k1");
    EXPECT_NEAR(k1.mean, 2e4, 0.3 * k1.std);
    return k1.std;
  };
  EXPECT_GT(deviation_after_rest({}), 2.5e3);  // 300 sqrt(120) = 3290
  EXPECT_LT(deviation_after_rest(gated), 1.11e3);
  EXPECT_GT(deviation_after_rest(gated), 0.9e3);
}

TEST(LiveGates, RefuseOptionsOutOfRange) {
  const auto with = [](GateOptions gates) {
    return refusal_of([&] {
      OnlineFilter(structure(2e6).base_displacement("road", "wheel.ground"), rate, {.sensors = sensors},
                   {.gates = gates});
    });
  };
  EXPECT_THAT(with({.limit = 1.0, .memory = 3}),
              testing::AllOf(testing::HasSubstr("gates.limit: 1"), testing::HasSubstr("gates.memory: 3")));
  EXPECT_THAT(with({.suspend_after = 200}), testing::HasSubstr("gates.suspend_after: 200"));
}

}  // namespace
}  // namespace kalfem::quarter_car
