// SPDX-License-Identifier: Apache-2.0
// One mass on a spring that softens, watched through the public interface.
#include <gmock/gmock.h>

#include <random>

#include "base/scratch_folder.hpp"
#include "kalfem/kalfem.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 200.0, stiffness = 2e5;
constexpr int seconds = 60;

Structure mass_on_a_spring(double k) {
  Structure s;
  s.add(lumped("frame").mass("1", 100.0).spring("k", "ground", "1", k, 200.0));
  return s.force("shaker", "frame.1");
}

const std::vector<SensorDescription> sensors{{"a", acceleration("frame.1"), 0.02}};

ChangeOptions changes() {
  return {.window = 2.0,
          .reference = 15,
          .memory = 15,
          .level = 0.01,
          .false_alarms_every = 1e6,
          .covariates = {{"temperature", 1e-3}}};
}

LiveFilter watched(const std::optional<ChangeOptions>& options) {
  return {
      mass_on_a_spring(stiffness),
      rate,
      {.sensors = sensors, .unknowns = {{"frame.k.stiffness", {.initial = 1.01 * stiffness, .std = 0.1 * stiffness}}}},
      {.horizon = 2.0, .filter = {.window = 400, .changes = options}}};
}

double temperature(double t) { return 290.0 + 5.0 * std::sin(t / 3.0); }

/// A minute of the force and of what the sensor shows, from the end of another.
struct Minute {
  VectorXd force, measured;
};
Minute minute(double k, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 50.0);
  VectorXd force(Index(seconds * rate) + 1);
  for (double& each : force) each = normal(random);
  force[0] = 0.0;
  Structure s = mass_on_a_spring(k);
  s.drive("shaker", Samples{force, rate});
  const auto record =
      simulate(s, {.sensors = sensors, .duration = double(seconds), .sample_rate = rate, .seed = seed}).record;
  return {force, record.values.row(0).transpose()};
}

/// Pushes a minute, a second at a time.
void push(const Minute& minute, double start, LiveFilter& live, bool with_temperature = true) {
  const auto block = Index(rate);
  for (Index first = 0; first < Index(seconds * rate); first += block) {
    const double t = start + double(first) / rate;
    if (with_temperature) live.push("temperature", t, VectorXd::Constant(1, temperature(t)));
    live.push("shaker", t, minute.force.segment(first, block));
    live.push("a", t, minute.measured.segment(first, block));
  }
}

TEST(MonitoredMass, RaisesOneAlarmWithItsBandAndEndsIt) {
  LiveFilter live = watched(changes());
  for (int k = 0; k < 2; ++k) push(minute(stiffness, unsigned(k + 1)), 60.0 * k, live);
  EXPECT_THAT(live.filter().alarms(), testing::IsEmpty());
  for (int k = 2; k < 4; ++k) push(minute(0.97 * stiffness, unsigned(k + 1)), 60.0 * k, live);
  auto alarms = live.filter().alarms();
  ASSERT_EQ(alarms.size(), 1U);
  EXPECT_EQ(alarms[0].kind, AlarmKind::raised);
  EXPECT_EQ(alarms[0].what.parameter, "frame.k.stiffness");
  EXPECT_LE(alarms[0].what.earliest, 122.0);
  EXPECT_GE(alarms[0].what.latest, 116.0);
  const auto standing = live.filter().changes();
  ASSERT_EQ(standing.size(), 1U);
  EXPECT_NEAR(standing[0].change, -0.03 / 1.01, 4.0 * standing[0].std);
  EXPECT_LT(standing[0].std, 0.003);
  for (int k = 4; k < 6; ++k) push(minute(stiffness, unsigned(k + 1)), 60.0 * k, live);
  alarms = live.filter().alarms();
  ASSERT_GE(alarms.size(), 2U);
  ASSERT_LE(alarms.size(), 3U);  // the window in which it came back may be told as a change of its own
  if (alarms.size() == 3) EXPECT_EQ(alarms[1].kind, AlarmKind::changed);
  EXPECT_EQ(alarms.back().kind, AlarmKind::ended);
  EXPECT_THAT(live.filter().changes(), testing::IsEmpty());
  const auto trend = live.filter().trend();
  ASSERT_EQ(trend.size(), 1U);
  EXPECT_GT(trend[0].windows, 100);
  EXPECT_NEAR(trend[0].measured.mean, 0.99 * stiffness, 0.01 * stiffness);
}

TEST(MonitoredMass, GoesOnWithTheSameBitsAfterARestart) {
  const ScratchFolder folder("monitored_restart");
  LiveFilter whole = watched(changes()), first = watched(changes());
  for (int k = 0; k < 2; ++k)
    for (auto* live : {&whole, &first}) push(minute(stiffness, unsigned(k + 1)), 60.0 * k, *live);
  first.write_state(folder / "state");
  LiveFilter second = watched(changes());
  second.read_state(folder / "state");
  for (auto* live : {&whole, &second}) push(minute(0.97 * stiffness, 3), 120.0, *live);
  ASSERT_EQ(whole.filter().alarms().size(), 1U);
  ASSERT_EQ(second.filter().alarms().size(), 1U);
  EXPECT_EQ(whole.filter().alarms()[0].text, second.filter().alarms()[0].text);
  EXPECT_EQ(whole.filter().changes()[0].change, second.filter().changes()[0].change);
  auto others = changes();
  others.level = 0.02;
  EXPECT_THROW(watched(others).read_state(folder / "state"), InvalidInput);
}

TEST(MonitoredMass, WaitsForACovariateThatDoesNotCome) {
  LiveFilter live = watched(changes());
  push(minute(stiffness, 1), 0.0, live, false);
  EXPECT_EQ(live.filter().trend().size(), 0U);
  EXPECT_THROW(live.filter().covariate("wind", 0.0, 1.0), InvalidInput);
}

TEST(MonitoredMass, RefusesOptionsOutOfRange) {
  auto wrong = changes();
  wrong.level = 0.0;
  wrong.memory = 1;
  wrong.covariates.push_back({"temperature", -1.0});
  try {
    watched(wrong);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 4U) << error.what();
  }
}

}  // namespace
}  // namespace kalfem
