// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/case_edit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"

namespace kalfem {
namespace {

const std::string measured = R"(kalfem: 1
substructures:
  s: {masses: {1: 1 kg, 2: 1 kg}, springs: [{name: k, from: ground, to: 1, stiffness: 400}], damping: {modal: 1 %}}
connectors:
  strut: {from: s.1, to: s.2, law: linear, parameters: {k: 100, c: 1}}
CONNECTORS
sensors:
  a: {displacement: s.1, noise: 1 mm, channel: x, gain: 2, delay: 3 ms, drift: 40 ppm}
  b: {displacement: s.2, noise: 1 mm}
record: {file: record.csv}
estimate:
  unknown:
    strut.k: {initial: 90 N/m, std: 20 N/m}
UNKNOWNS
)";

class CaseEdits : public testing::Test {
protected:
  CaseEdits() {
    std::ofstream file(folder_ / "record.csv");
    file << "time [s],x [m],b [m]\n";
    for (int k = 0; k < 200; ++k) file << 0.01 * k << "," << std::sin(0.2 * k) << "," << std::cos(0.3 * k) << "\n";
    file.close();
    study_ = with("", "");
    outcome_.measurements.sample_rate = 100.0;
    outcome_.measurements.channels = {{.name = "a", .unit = "m", .noise = 1e-3},
                                      {.name = "b", .unit = "m", .noise = 1e-3}};
  }

  [[nodiscard]] Study with(const std::string& connectors, const std::string& unknowns) const {
    std::string text = measured;
    text.replace(text.find("CONNECTORS"), 10, connectors);
    text.replace(text.find("UNKNOWNS"), 8, unknowns);
    return test::study_of(text, folder_ / "case.yaml");
  }

  [[nodiscard]] std::string edit(const TestedHypothesis& cause) const {
    return edit_against(cause, study_, outcome_).yaml();
  }

  ScratchFolder folder_{"case-edit"};
  Study study_;
  EstimationOutcome outcome_;
};

/// The channel holds gain signal + offset, late by delay + drift t; what the case gives of these stays in force.
TEST_F(CaseEdits, OfAChannelStartFromWhatTheCaseGives) {
  EXPECT_EQ(edit({.code = "sensor_sign", .subject = "a"}), "sensors:\n  a: {gain: -2}\n");
  EXPECT_EQ(edit({.code = "sensor_sign", .subject = "b"}), "sensors:\n  b: {gain: -1}\n");
  EXPECT_EQ(edit({.code = "sensor_gain", .subject = "a", .value = 1.5}), "sensors:\n  a: {gain: 3}\n");
  EXPECT_EQ(edit({.code = "sensor_unit", .subject = "b", .value = 9.80665, .turned = true}),
            "sensors:\n  b: {gain: -9.807}\n");
  EXPECT_EQ(edit({.code = "sensor_delay", .subject = "a", .value = 2.0}), "sensors:\n  a: {delay: 23 ms}\n");
  EXPECT_EQ(edit({.code = "sensor_drift", .subject = "a, b", .value = 1e-5, .fitted = 1}),
            "sensors:\n  a: {drift: 50 ppm}\n  b: {drift: 10 ppm}\n");
  EXPECT_EQ(edit({.code = "sensor_offset", .subject = "b", .value = -0.02}), "sensors:\n  b: {offset: -20 mm}\n");
  EXPECT_EQ(edit({.code = "sensor_noise", .subject = "b", .value = 3.0}), "sensors:\n  b: {noise: 3 mm}\n");
  EXPECT_EQ(edit({.code = "sensors_swapped", .subject = "a, b"}), "sensors:\n  a: {channel: b}\n  b: {channel: x}\n");
}

TEST_F(CaseEdits, AreNoneWhereNoKeyMendsTheMistake) {
  EXPECT_EQ(edit({.code = "sensor_saturated", .subject = "a"}), "");
  EXPECT_EQ(edit({.code = "sensor_drift", .subject = "a", .value = 1e-5, .fitted = 2}), "");  // and a delay
  EXPECT_EQ(edit({.code = "sensor_sign", .subject = "no_sensor"}), "");
  EXPECT_EQ(edit({.code = "excitation_rate", .subject = "road", .value = 1.01}), "");
  EXPECT_EQ(edit({.code = "first_guess", .subject = "no_unknown", .value = 3.0}), "");
}

TEST_F(CaseEdits, OfAFirstGuessKeepItsRelativeWidth) {
  EXPECT_EQ(edit({.code = "first_guess", .subject = "strut.k", .value = 10.0}),
            "estimate:\n  unknown:\n    strut.k: {initial: 900 N/m, std: 200 N/m}\n");
}

/// Forces with and without a place and a state: the edit loads as it stands, and the law gives the force.
TEST_F(CaseEdits, OfALackingForceAreConnectorsThatLoad) {
  const CaseEdit found = edit_against({.code = "wrong_law",
                                       .subject = "strut",
                                       .forces = {{.name = "strut_cubic_stiffness",
                                                   .from = "s.1",
                                                   .to = "s.2",
                                                   .force = "K*x^3",
                                                   .factor = 1234.5678,
                                                   .deviation = 2e3},
                                                  {.name = "strut_lag",
                                                   .from = "s.1",
                                                   .to = "s.2",
                                                   .force = "K*(x - z)",
                                                   .states = {{"z", "(x - z)/s"}},
                                                   .factor = 55.0,
                                                   .deviation = 20.0,
                                                   .place = 0.03}}},
                                      study_, outcome_);
  ASSERT_EQ(found.connectors.size(), 2u);
  ASSERT_EQ(found.unknowns.size(), 2u);
  const Study edited = with("  " + found.connectors[0] + "\n  " + found.connectors[1],
                            "    " + found.unknowns[0] + "\n    " + found.unknowns[1]);
  const auto& connectors = edited.structure->parts.connectors;
  ASSERT_EQ(connectors.size(), 3u);
  EXPECT_EQ(connectors[1].parameters[0], 1235.0);  // four digits
  EXPECT_EQ(connectors[2].parameters[1], 0.03);
  EXPECT_EQ(connectors[2].law->states().size(), 1u);
  EXPECT_EQ(edited.problem->settings.unknowns[2].deviation, 20.0);
}

}  // namespace
}  // namespace kalfem
