// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/watcher.hpp"

#include <random>

#include "api/quarter_car.hpp"
#include "kalfem/live/state_file.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/watch/change_lines.hpp"
#include "kalfem/watch/playback.hpp"
#include "live_case.hpp"

namespace kalfem::live_case {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

constexpr double duration = 20.0;

const Record& drive() {
  static const Record record = quarter_car::drive(duration, quarter_car::road_of(duration));
  return record;
}

Eigen::VectorXd road() {
  return quarter_car::road_of(duration)->sample(0.0, 1.0 / quarter_car::rate, drive().samples()).col(0).matrix();
}

/// What is published of the drive.
const Playback& published() {
  static const Playback playback{
      .sample_rate = quarter_car::rate,
      .channels = {
          {"wheel", drive().values.row(0).transpose()}, {"body", drive().values.row(1).transpose()}, {"road", road()}}};
  return playback;
}

std::vector<std::string> lines_of(const Playback& playback, Eigen::Index block) {
  std::vector<std::string> lines;
  for (Eigen::Index first = 0; first < playback.samples(); first += block)
    for (auto& line : playback.lines(first, std::min(block, playback.samples() - first)))
      lines.push_back(std::move(line));
  return lines;
}

LivePlan plan_of(const std::string& text) {
  const ScratchFolder folder("watch_plan");
  return make_live_plan(load_study(written(folder / "live.yaml", text)));
}

/// A watcher with all that it says.
struct Watched {
  std::vector<std::string> said, complaints;
  Watcher watcher;

  explicit Watched(const std::string& text = live())
      : watcher(
            plan_of(text), [this](MessageKind, const std::string& line) { said.push_back(line); },
            [this](const std::string& line) { complaints.push_back(line); }) {}

  void take(const std::vector<std::string>& lines) {
    for (const auto& line : lines) watcher.take(line);
  }
  Json last() {
    watcher.tell();
    return Json::parse(said.back());
  }
  double estimate() { return last()["parameters"]["strut.k3"]["estimate"]; }
  double std() { return last()["parameters"]["strut.k3"]["std"]; }
};

TEST(Watcher, AgreesWithARunOverTheSameRecord) {
  Watched live_one;
  live_one.take(lines_of(published(), 10));
  EXPECT_TRUE(live_one.complaints.empty());
  const auto whole = estimate(
      quarter_car::structure(2e6).base_displacement("road", "wheel.ground", Samples{road(), quarter_car::rate}),
      drive(),
      {.sensors = quarter_car::sensors, .unknowns = {{"strut.k3", {.std = 2e6}}}, .substeps = 4, .diagnose = false});
  const auto& expected = whole.parameter("strut.k3");
  // The spline of the road ends `input_delay` samples behind: 0.27^8 of its curvature, and eight samples fewer.
  EXPECT_NEAR(live_one.estimate(), expected.mean, 0.05 * expected.std);
  EXPECT_NEAR(live_one.std(), expected.std, 0.01 * expected.std);
  EXPECT_LT(std::abs(live_one.estimate() - 3e6), 3.0 * expected.std);
}

TEST(Watcher, SaysTheSameWhateverTheBlocks) {
  Watched one, another;
  one.take(lines_of(published(), 1));
  another.take(lines_of(published(), 37));
  ASSERT_GE(one.said.size(), 39U);  // one each half a second, eight samples behind
  ASSERT_EQ(one.said.size(), another.said.size());
  for (std::size_t i = 0; i < one.said.size(); ++i) {
    Json a = Json::parse(one.said[i]), b = Json::parse(another.said[i]);
    a.erase("samples"), b.erase("samples");  // those that wait for later inputs
    EXPECT_EQ(a, b);
  }
  const auto first = Json::parse(one.said[2]);
  EXPECT_EQ(first["t"], 1.0);
  EXPECT_EQ(first["condition"], "warming up");
  EXPECT_TRUE(first["outputs"]["body.b.displacement"]["std"].is_number());
}

class WatcherRestart : public testing::TestWithParam<std::string> {};

TEST_P(WatcherRestart, GivesTheSameBits) {
  const ScratchFolder folder("watch_restart");
  auto lines = lines_of(published(), 10);
  lines.insert(lines.begin() + 100, "nonsense");
  Watched whole(live(GetParam()));
  whole.take(lines);
  std::mt19937 random(2);
  std::vector<std::string> said;
  auto parted = std::make_unique<Watched>(live(GetParam()));
  for (const auto& line : lines) {
    if (random() % 100 == 0) {
      write_state_file(folder / "state", parted->watcher.fingerprint(), parted->watcher);
      said.insert(said.end(), parted->said.begin(), parted->said.end());
      parted = std::make_unique<Watched>(live(GetParam()));
      read_state_file(folder / "state", parted->watcher.fingerprint(), parted->watcher);
    }
    parted->watcher.take(line);
  }
  said.insert(said.end(), parted->said.begin(), parted->said.end());
  EXPECT_EQ(said, whole.said);
}

INSTANTIATE_TEST_SUITE_P(Lags, WatcherRestart, testing::Values("", "lag: 25"));

TEST(Watcher, TellsSmoothedEstimatesInWhateverOrderTheLinesCome) {
  Watched one(live("start: 0 s, lag: 25")), mixed(live("start: 0 s, lag: 25"));
  auto lines = lines_of(published(), 10);
  one.take(lines);
  std::mt19937 random(5);
  for (std::size_t i = 0; i + 8 <= lines.size(); i += 8)  // 0.16 s, within the horizon
    std::shuffle(lines.begin() + long(i), lines.begin() + long(i) + 8, random);
  mixed.take(lines);
  const Json last = one.last();
  const Json& smoothed = last["smoothed"];
  EXPECT_NEAR(smoothed["t"].get<double>(), last["t"].get<double>() - 25.0 / quarter_car::rate, 1e-9);
  EXPECT_NEAR(smoothed["parameters"]["strut.k3"]["estimate"].get<double>(), one.estimate(), 1e-6 * one.std());
  EXPECT_EQ(mixed.last()["smoothed"], smoothed);
  EXPECT_FALSE(Watched().last().contains("smoothed"));
}

/// A road that was not measured, with a displacement that shows its slow part.
std::string unknown_road(const std::string& more) {
  std::string text = live(more, R"(
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2}
  level: {displacement: body.b, noise: 0.2 mm})");
  const std::string given = "file: live, channel: road", assumed = "unknown: {std: 8 mm, correlation_time: 50 ms}";
  text.replace(text.find(given), given.size(), assumed);
  text.erase(text.find("estimate:"));
  return text + "estimate: {}\n";
}

TEST(Watcher, EstimatesAnUnknownRoadAndNarrowsItsBandByALag) {
  Watched watched(unknown_road("lag: 25"));
  auto sensors = quarter_car::sensors;
  sensors.push_back({"level", displacement("body.b"), 2e-4});
  const auto record =
      simulate(quarter_car::structure(3e6).base_displacement("road", "wheel.ground", quarter_car::road_of(duration)),
               {.sensors = sensors, .duration = duration, .sample_rate = quarter_car::rate, .seed = 2})
          .record;
  Playback playback{.sample_rate = quarter_car::rate, .channels = {}};
  for (Eigen::Index i = 0; i < 3; ++i)
    playback.channels.push_back({sensors[std::size_t(i)].name, record.values.row(i).transpose()});
  watched.take(lines_of(playback, 10));
  EXPECT_TRUE(watched.complaints.empty());
  double now = 0.0, later = 0.0;
  int told = 0;
  for (const auto& line : watched.said) {
    const Json each = Json::parse(line);
    const Json &present = each["outputs"]["road"], &smoothed = each["smoothed"]["outputs"]["road"];
    const auto sample = std::lround(each["smoothed"]["t"].get<double>() * quarter_car::rate);
    EXPECT_LT(std::abs(smoothed["mean"].get<double>() - road()[sample]), 5.0 * smoothed["std"].get<double>());
    now += present["std"].get<double>();
    later += smoothed["std"].get<double>();
    ++told;
  }
  ASSERT_GT(told, 30);
  std::cout << "std of the road: " << 1e3 * now / told << " mm now, " << 1e3 * later / told << " mm later\n";
  EXPECT_LT(later, 0.8 * now);
}

TEST(Watcher, TellsBadLinesAndGoesOn) {
  Watched watched;
  auto lines = lines_of(published(), 10);
  lines.insert(lines.begin() + 10, {"nonsense", R"({"t": 0.2, "whel": [1]})", R"({"t": 0.2013, "wheel": [1]})",
                                    R"({"t": 0.2, "dt": 0.01, "wheel": [1, 2]})", R"({"t": 0.2, "whel": [1]})"});
  watched.take(lines);
  ASSERT_EQ(watched.complaints.size(), 4U);
  EXPECT_THAT(watched.complaints[0], HasSubstr("line 11: the line 'nonsense' is neither JSON nor CSV"));
  EXPECT_THAT(watched.complaints[1], HasSubstr("no channel 'whel' (did you mean 'wheel'?)"));
  EXPECT_THAT(watched.complaints[2], HasSubstr("lies between two samples"));
  EXPECT_THAT(watched.complaints[3], HasSubstr("a sampling rate of 500 Hz"));
  Watched clean;
  clean.take(lines_of(published(), 10));
  EXPECT_EQ(watched.last()["bad_lines"], 3);
  EXPECT_EQ(watched.estimate(), clean.estimate());
}

TEST(Watcher, UndoesUnitGainOffsetAndDelay) {
  Watched plain, calibrated(live("unit: m/s^2", R"(
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2, channel: A1, unit: mm/s^2, gain: -2, offset: 0.3 m/s^2, delay: 0.04 s}
  body: {acceleration: body.b, noise: 0.02 m/s^2})"));
  Playback published_otherwise = published();
  auto& wheel = published_otherwise.channels[0];
  wheel = {"A1", (-2.0 * wheel.values.array() + 0.3) * 1000.0, 0.04};
  plain.take(lines_of(published(), 10));
  calibrated.take(lines_of(published_otherwise, 10));
  EXPECT_TRUE(calibrated.complaints.empty());
  EXPECT_NEAR(calibrated.estimate(), plain.estimate(), 1e-6 * plain.std());
}

TEST(Watcher, NamesASensorThatDies) {
  Playback playback = published();
  apply_faults({scheduled_fault("dead:body:8:14")}, playback);
  Watched watched;
  watched.take(lines_of(playback, 10));
  std::vector<std::string> kinds;
  for (const auto& line : watched.said) {
    const Json told = Json::parse(line);
    for (const auto& event : told["events"])
      if (event["kind"] != "spike") kinds.push_back(event["kind"]);
  }
  EXPECT_THAT(kinds, testing::AllOf(testing::Contains("stuck"), testing::Contains("back")));
  EXPECT_LT(std::abs(watched.estimate() - 3e6), 3.0 * watched.std());
  Watched trusting(live("gated: false"));
  trusting.take(lines_of(playback, 10));
  EXPECT_GT(std::abs(trusting.estimate() - 3e6), 10.0 * trusting.std());
}

TEST(Watcher, TellsAWrongUnitOnceAndLeavesItOut) {
  Watched watched;
  watched.take({R"({"t": 0, "unit": "kg", "wheel": [1, 2]})", R"({"t": 0.004, "unit": "kg", "wheel": [1, 2]})"});
  ASSERT_EQ(watched.complaints.size(), 1U);
  EXPECT_THAT(watched.complaints[0], HasSubstr("'wheel' comes in 'kg'"));
  EXPECT_EQ(watched.last()["bad_lines"], 2);
  EXPECT_EQ(watched.last()["samples"], 0);
}

TEST(Watcher, TellsAlarmsAndKeepsATrend) {
  const std::string alarms =
      "alarms: {window: 0.5 s, reference: 10, memory: 10, level: 1 %, covariates: {warmth: {channel: T}}}";
  Watched watched(live(alarms));
  auto lines = lines_of(published(), 10);
  for (auto& line : lines) line.insert(line.size() - 1, R"(,"T":[20])");
  watched.take(lines);
  EXPECT_TRUE(watched.complaints.empty());
  const Json last = watched.last();
  EXPECT_EQ(last["reference"]["windows"], 10);
  EXPECT_EQ(last["changes"], Json::array());
  ASSERT_NE(watched.watcher.monitor(), nullptr);
  const auto table = trend_table(*watched.watcher.monitor());
  EXPECT_THAT(table, HasSubstr("\n0,strut.k3,N/m^3,"));
  EXPECT_EQ(Watched().watcher.monitor(), nullptr);
}

std::string refusal_of(const std::string& text) try {
  plan_of(text);
  return "";
} catch (const InvalidInput& error) {
  return error.what();
}

TEST(LivePlan, RefusesWhatOnlyAWholeRecordAllows) {
  EXPECT_THAT(refusal_of(live("", "\n  body: {acceleration: body.b, noise: 5 %}")),
              HasSubstr("sensors.body.noise is per cent of the channel's rms"));
  EXPECT_THAT(refusal_of(live("", "\n  body: {acceleration: body.b, noise: 0.02, delay: 1.3 ms}")),
              HasSubstr("sensors.body.delay is 0.0013 s"));
  std::string passes = live();
  passes.replace(passes.find("estimate:\n"), 10, "estimate:\n  passes: 2\n  smooth: true\n");
  EXPECT_THAT(refusal_of(passes), testing::AllOf(HasSubstr("estimate.passes needs a whole record"),
                                                 HasSubstr("estimate.smooth needs a whole record")));
  EXPECT_THAT(refusal_of(live() + "simulate: {duration: 1 s, sample_rate: 500 Hz}\n"),
              HasSubstr("both `live` and `simulate`"));
  EXPECT_THAT(refusal_of(live("alarms: {covariates: {warmth: {channel: wheel}}}")),
              HasSubstr("live.alarms.covariates.warmth.channel is 'wheel', that of sensors.wheel"));
  EXPECT_THAT(refusal_of(live("alarms: {window: 1 ms}")), HasSubstr("live.alarms.window is 0.5 samples"));
  EXPECT_THAT(refusal_of(live("mqtt: {broker: localhost}")), HasSubstr("mqtt has neither topics nor publish"));
  EXPECT_THAT(refusal_of(live("port: 5000, mqtt: {topics: [a]}")), HasSubstr("both `port` and `mqtt.topics`"));
  EXPECT_THAT(refusal_of(structure + "live: {sample_rate: 500 Hz}\n"), HasSubstr("`live` but no `estimate`"));
}

TEST(LivePlan, NamesTheLineOfALagThatMemoryDoesNotHold) {
  std::string masses, springs;
  for (int i = 1; i <= 100; ++i) {
    const std::string name = "t" + std::to_string(i);
    masses += (i == 1 ? "" : ", ") + name + ": 1 kg";
    springs += (i == 1 ? "" : ", ") + ("{from: ground, to: " + name + ", stiffness: 1 kN/m}");
  }
  std::string tower = live("lag: 100000");
  tower.replace(tower.find("connectors:"), 0, "  tower: {masses: {" + masses + "}, springs: [" + springs + "]}\n");
  EXPECT_THAT(refusal_of(tower), testing::ContainsRegex("live.yaml:[0-9]+: lag: 100000 samples of [0-9]+ states need"));
}

}  // namespace
}  // namespace kalfem::live_case
