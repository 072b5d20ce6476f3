// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "updating_case.hpp"

// Standard deviations of the frequencies that `modifications` predicts.

namespace kalfem::test {
namespace {

/// One mass on one spring: f = sqrt(k / m) / 2 pi.
const std::string oscillator = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg}
    springs: [{name: s, from: ground, to: 1, stiffness: 1.2 kN/m}]
update:
  parameters:
    frame.s.stiffness: {std: 20 %}
    frame.1.mass: {std: 10 %}
  compare:
    modes: {modes: frame, frequencies: [5.0329212], deviation: 2 %}
modifications:
  stiffer: {substructure: frame, set: {s.stiffness: 2 kN/m}, modes: 1}
  heavier: {substructure: frame, set: {1.mass: 2 kg}, modes: 1}
)";

class ModificationDeviations : public testing::Test {
protected:
  void SetUp() override { summary_ = updated(ScratchFolder("modification"), oscillator); }
  [[nodiscard]] double std_of(const std::string& parameter) const {
    return summary_["updating"]["parameters"]["frame." + parameter]["std"].get<double>();
  }
  [[nodiscard]] double estimate(const std::string& parameter) const {
    return summary_["updating"]["parameters"]["frame." + parameter]["estimate"].get<double>();
  }
  nlohmann::json summary_;
};

TEST_F(ModificationDeviations, AreThoseOfTheParametersToFirstOrder) {
  // d f / f = dk / 2k: the modification sets the mass, so only the spring's deviation counts. And the other way round.
  const auto& heavier = summary_["prediction"]["heavier"];
  const double f = heavier["frequencies_hz"][0];
  EXPECT_NEAR(f, std::sqrt(estimate("s.stiffness") / 2.0) / (2.0 * std::numbers::pi), 1e-14 * f);  // rounding
  EXPECT_NEAR(heavier["frequencies_std_hz"][0].get<double>(), 0.5 * f * std_of("s.stiffness") / estimate("s.stiffness"),
              1e-14 * f);
  const auto& stiffer = summary_["prediction"]["stiffer"];
  const double g = stiffer["frequencies_hz"][0];
  EXPECT_NEAR(stiffer["frequencies_std_hz"][0].get<double>(), 0.5 * g * std_of("1.mass") / estimate("1.mass"),
              1e-14 * g);
}

TEST_F(ModificationDeviations, CountTheCovariancesOfParameters) {
  // Stiffness and mass are each known to 20 and 10 %, their ratio to 4 %: a modification that touches neither is known
  // to what the measured frequency is known.
  auto text = changed(oscillator, "masses: {1: 1 kg}", "masses: {1: 1 kg, 2: 1 kg}");
  text = changed(text, "stiffness: 1.2 kN/m}]",
                 "stiffness: 1.2 kN/m}, {name: far, from: ground, to: 2, stiffness: 100 kN/m}]");
  text = changed(text, "set: {1.mass: 2 kg}", "set: {2.mass: 2 kg}");
  const auto summary = updated(ScratchFolder("modification-covariance"), text);
  const auto& untouched = summary["prediction"]["heavier"];
  const double f = untouched["frequencies_hz"][0];
  // The prior of f, 11 %, and what is measured, 2 %, at the estimate; their precisions add up.
  const auto& parameters = summary["updating"]["parameters"];
  const double k = parameters["frame.s.stiffness"]["estimate"], m = parameters["frame.1.mass"]["estimate"];
  const double prior = 0.5 * std::hypot(0.2 * 1200.0 / k, 0.1 * 1.0 / m);
  const double measured = 0.02 * 5.0329212 / (std::sqrt(k / m) / (2.0 * std::numbers::pi));
  EXPECT_NEAR(untouched["frequencies_std_hz"][0].get<double>() / f, prior * measured / std::hypot(prior, measured),
              1e-14);
}

TEST_F(ModificationDeviations, HoldStatedNumbersThatTheParametersFollow) {
  // The frequency is measured to .2 %, so the stiffness follows a mass that is 3 % heavier by 3 %, but for its prior.
  auto text = changed(oscillator, "    frame.1.mass: {std: 10 %}\n", "");
  text = changed(text, "deviation: 2 %", "deviation: 0.2 %");
  const auto alone = updated(ScratchFolder("modification-alone"), text)["prediction"];
  text = changed(text, "update:\n", "update:\n  known_to: {frame.1.mass: 3 %}\n");
  const auto summary = updated(ScratchFolder("modification-stated"), text);
  const double k = summary["updating"]["parameters"]["frame.s.stiffness"]["estimate"];
  const double f = std::sqrt(k) / (2.0 * std::numbers::pi);
  const double measured = std::pow(0.5 / (0.002 * 5.0329212 / f), 2.0), prior = std::pow(k / 240.0, 2.0);
  const auto added = [&](const char* name) {
    const double with = summary["prediction"][name]["frequencies_std_hz"][0],
                 without = alone[name]["frequencies_std_hz"][0];
    return std::sqrt(with * with - without * without) / summary["prediction"][name]["frequencies_hz"][0].get<double>();
  };
  EXPECT_NEAR(added("heavier"), 0.5 * 0.03 * measured / (measured + prior), 1e-8);  // sets the mass
  EXPECT_NEAR(added("stiffer"), 0.5 * 0.03, 1e-8);                                  // sets the stiffness
}

// Both fit the one frequency. With stiffness alone a modification that doubles the mass is at f / sqrt(2); with mass
// alone one that sets the mass keeps the initial stiffness.
TEST_F(ModificationDeviations, HoldTheSpreadBetweenChoicesOfParameters) {
  auto text = changed(oscillator, "    frame.1.mass: {std: 10 %}\n", "");
  text = changed(text, "update:\n", "update:\n  alternatives: {of_mass: {parameters: {frame.1.mass: {std: 20 %}}}}\n");
  const auto summary = updated(ScratchFolder("modification-choices"), text);
  const auto& updating = summary["updating"];
  const double weight = updating["weight"], other = updating["alternatives"]["of_mass"]["weight"];
  EXPECT_NEAR(weight + other, 1.0, 1e-12);
  const double difference =
      updating["log_evidence"].get<double>() - updating["alternatives"]["of_mass"]["log_evidence"].get<double>();
  EXPECT_NEAR(std::log(weight / other), difference, 1e-9);
  const auto& heavier = summary["prediction"]["heavier"];
  const auto of = [&](const char* choice, const char* what) {
    return heavier["by_choice"][choice][what][0].get<double>();
  };
  const double one = of("as given", "frequencies_hz"), two = of("of_mass", "frequencies_hz");
  EXPECT_GT(std::abs(one - two), 0.01 * one);
  const double mean = weight * one + other * two;
  EXPECT_NEAR(heavier["frequencies_hz"][0].get<double>(), mean, 1e-12 * mean);
  const double variance = weight * (std::pow(of("as given", "frequencies_std_hz"), 2.0) + std::pow(one - mean, 2.0)) +
                          other * (std::pow(of("of_mass", "frequencies_std_hz"), 2.0) + std::pow(two - mean, 2.0));
  EXPECT_NEAR(heavier["frequencies_std_hz"][0].get<double>(), std::sqrt(variance), 1e-12 * mean);
}

TEST_F(ModificationDeviations, NeedAPriorOfEveryParameterWhereChoicesAreWeighed) {
  const auto text =
      changed(oscillator, "update:\n", "update:\n  alternatives: {of_mass: {parameters: {frame.1.mass: {}}}}\n");
  const ScratchFolder folder("modification-no-prior");
  const auto outcome = run_command("check " + written(folder, text).string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("alternatives.of_mass.parameters.frame.1.mass: it has no prior"), std::string::npos)
      << outcome.errors;
}

TEST_F(ModificationDeviations, SayWhatTheyLeaveOut) {
  EXPECT_NE(summary_["prediction"]["heavier"]["note"].get<std::string>().find("do not include"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
