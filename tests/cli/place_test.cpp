// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "command.hpp"

namespace kalfem::test {
namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

const std::string frame = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 2 kg, 2: 3 kg}
    springs: [{from: ground, to: 1, stiffness: 800 N/m, damping: 4 N s/m}]
  aside: {masses: {1: 1 kg}, springs: [{from: ground, to: 1, stiffness: 500 N/m}]}
connectors:
  mount: {from: frame.1, to: frame.2, law: linear, parameters: {k: 500 N/m, c: 3 N s/m}}
excitation:
  push: {force: frame.2, sine: {amplitude: 10 N, frequency: 2 Hz}}
sensors:
  y: {displacement: frame.2, noise: 0.1 mm}
simulate: {duration: 1 s, sample_rate: 100 Hz}
)";

const std::string estimate =
    "estimate: {unknown: {mount.k: {initial: 500, std: 100}, mount.c: {initial: 3, std: 1}}}\n";

class Place : public testing::Test {
protected:
  Outcome run(const std::string& text, const std::string& verb = "place") {
    const std::string file = (folder_ / "case.yaml").string();
    std::ofstream(file) << text;
    return run_command(verb + " " + file + " --out " + (folder_ / "out").string(), folder_);
  }
  [[nodiscard]] Json placement() const { return read_summary(folder_ / "out")["placement"]; }

  ScratchFolder folder_{"place"};
};

double relative(const Json& deviations) {
  const double k = deviations["suspension.mu_k1"].get<double>() / 20.0,
               c = deviations["suspension.mu_c1"].get<double>() / 10.0;
  return std::sqrt((k * k + c * c) / 2.0);
}

TEST_F(Place, RanksAllSetsOfTheChain) {
  const auto outcome =
      run_command("place " + example("chain/place.yaml") + " --out " + (folder_ / "out").string(), folder_);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const Json found = placement();
  EXPECT_TRUE(found["exact"]);
  EXPECT_EQ(found["tried"], 330);
  EXPECT_EQ(found["sets"].size(), 20u);
  EXPECT_EQ(found["sets"][0]["sensors"].get<Names>(), (Names{"wheel.w", "body.3", "body.4", "body.8"}));
  EXPECT_NEAR(100.0 * relative(found["sets"][0]["deviations"]), 0.1054, 5e-5);
  EXPECT_EQ(found["own_set"]["rank"], 271);
  EXPECT_NEAR(100.0 * relative(found["own_set"]["deviations"]), 0.1403, 5e-5);
  EXPECT_EQ(found["candidates"].size(), 11u);
  ASSERT_EQ(found["filter"].size(), 5u);
  for (const auto& each : found["filter"])
    for (const char* name : {"suspension.mu_k1", "suspension.mu_c1"})
      EXPECT_NEAR(each["filter"][name].get<double>() / each["bound"][name].get<double>(), 1.0, 0.01);
  EXPECT_EQ(outcome.output.find("Best of all 330 sets of 4 sensors: wheel.w, body.3, body.4, body.8"),
            outcome.output.find("Best"));
  const std::string page = read(folder_ / "out" / "report.html");
  EXPECT_NE(page.find("Sensor placement"), std::string::npos);
  EXPECT_NE(page.find("class=\"placement-bars\""), std::string::npos);
}

TEST_F(Place, RefusesSeveralMistakesAtOnceEachWithItsLine) {
  const auto outcome = run(frame + estimate + R"(place:
  candidates:
    floors:
      acceleration: [frame.1, frame.3, frame.1, frame.ground]
      noise: 0 %
    gauge: {displacement: frame.2, noise: 1 mm, triaxial: true}
  count: 9
  parameters: [mount.k, mount.m]
  keep: [z]
)");
  EXPECT_EQ(outcome.code, 2);
  for (const char* expected :
       {"case.yaml:18: place.candidates.floors.acceleration[1]: there is no point or node 'frame.3' (did you mean",
        "case.yaml:18: place.candidates.floors.acceleration[2]: the candidate 'frame.1' is given twice",
        "case.yaml:18: place.candidates.floors.acceleration[3]: 'frame.ground' is a ground",
        "case.yaml:19: place.candidates.floors.noise: the noise is 0 %",
        "case.yaml:20: place.candidates.gauge.displacement: 'frame.2' is one direction",
        "case.yaml:21: place.count: 9 sensors are to be placed, but there are 2 candidates",
        "case.yaml:22: place.parameters[1]: there is no unknown 'mount.m' of the structure",
        "case.yaml:23: place.keep"})
    EXPECT_NE(outcome.errors.find(expected), std::string::npos) << expected << "\n" << outcome.errors;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(Place, NeedsAnEstimateAndItsSection) {
  const std::string place = "place: {candidates: {g: {acceleration: all, noise: 1 %}}, count: 1}\n";
  const auto without_estimate = run(frame + place);
  EXPECT_EQ(without_estimate.code, 2);
  EXPECT_NE(without_estimate.errors.find("case.yaml:14: place: the case has no `estimate`"), std::string::npos)
      << without_estimate.errors;
  const auto without_section = run(frame + estimate);
  EXPECT_EQ(without_section.code, 2);
  EXPECT_NE(without_section.errors.find("the case has no `place`"), std::string::npos) << without_section.errors;
  const auto without_record = run(frame.substr(0, frame.find("simulate")) + estimate + place);
  EXPECT_EQ(without_record.code, 2);
  EXPECT_NE(without_record.errors.find("add `simulate`, `record` or `live`"), std::string::npos)
      << without_record.errors;
}

TEST_F(Place, NeedsAnExpectedExcitation) {
  std::string text = frame + estimate + "place: {candidates: {g: {acceleration: all, noise: 1 %}}, count: 1}\n";
  const std::string known = "sine: {amplitude: 10 N, frequency: 2 Hz}";
  text.replace(text.find(known), known.size(), known + ", unknown: {std: 10 N}");
  const auto outcome = run(text);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("the excitation 'push' is unknown"), std::string::npos) << outcome.errors;
}

TEST_F(Place, SaysWhichCandidatesTellNothing) {
  const auto outcome =
      run(frame + estimate + "place: {candidates: {g: {acceleration: all, noise: 1 %}}, count: 2}\n", "run");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json found = placement();
  EXPECT_EQ(found["sets"][0]["sensors"].get<Names>(), (Names{"frame.1", "frame.2"}));
  EXPECT_NE(found["remarks"].dump().find("tell nothing: aside.1."), std::string::npos) << found["remarks"];
  EXPECT_EQ(found["candidates"]["aside.1"]["rank"], 3);
}

}  // namespace
}  // namespace kalfem::test
