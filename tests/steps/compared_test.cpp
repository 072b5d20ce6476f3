// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <string>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/study_page.hpp"
#include "kalfem/steps/compared.hpp"
#include "kalfem/steps/modes/report.hpp"
#include "kalfem/steps/updating/outcome.hpp"

namespace kalfem {
namespace {

const std::string one_mass = R"(
kalfem: 1
substructures:
  s: {masses: {m: 1.0}, springs: [{name: k, from: ground, to: m, stiffness: 400}], damping: {modal: 1 %}}
excitation:
  f: {force: s.m, random: {rms: 1, band: [0.5, 8]}}
sensors:
  y: {displacement: s.m, noise: 2 %}
simulate: {duration: 2 s, sample_rate: 100 Hz}
estimate: {unknown: {s.k.stiffness: {initial: 380, std: 40}}}
)";

/// Three masses of 1 kg, held, whose frequencies are those of equal springs of 1 kN/m.
const std::string updated_chain = R"(
kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg}
    springs:
      - {name: s1, from: ground, to: 1, stiffness: 1.3 kN/m}
      - {name: s2, from: 1, to: 2, stiffness: 0.8 kN/m}
      - {name: s3, from: 2, to: 3, stiffness: 1.1 kN/m}
update:
  parameters: {frame.s1.stiffness: {}, frame.s2.stiffness: {}, frame.s3.stiffness: {}}
  compare:
    modes: {modes: frame, frequencies: [2.2398607, 6.2759501, 9.0690107], deviation: 0.1 %}
)";

nlohmann::ordered_json state_after(const std::string& text, std::string_view verb) {
  const auto study = test::study_of(text);
  return summarise(study, run_study(study, verb, {}))["verdict"]["state"];
}

/// Modes and a simulation agree with anything. They end well, without a verdict.
TEST(Compared, ARunWithoutMeasurementsHasNoVerdict) {
  for (const std::string verb : {"modes", "simulate"}) {
    const auto study = test::study_of(one_mass);
    const auto results = run_study(study, verb, {});
    EXPECT_TRUE(results.usable());
    EXPECT_FALSE(has_verdict(results)) << verb;
    EXPECT_TRUE(summarise(study, results)["verdict"]["state"].is_null()) << verb;
    EXPECT_FALSE(make_page(study, results).status) << verb;
  }
}

TEST(Compared, AnEstimationAndAnUpdatingHaveOne) {
  EXPECT_TRUE(state_after(one_mass, "estimate").is_string());
  EXPECT_EQ(state_after(updated_chain, "update"), "consistent");
}

/// Exact shapes of the chain of equal springs, sin(i angle), at a sensor of which the sign is wrong.
TEST(Compared, AMistakeOfAModalTestIsInVerdictAndSummary) {
  const ScratchFolder folder("correlate");
  const auto correlated = [&](double sign) {
    std::ofstream file(folder.path() / "shapes.csv");
    for (int floor = 1; floor <= 3; ++floor)
      for (int mode = 0; mode < 3; ++mode)
        file << (floor == 2 ? sign : 1.0) * std::sin(floor * (2 * mode + 1) * M_PI / 7.0) << (mode < 2 ? "," : "\n");
    file.close();
    std::string text = test::changed(
        updated_chain, "deviation: 0.1 %",
        "minimum_mac: 0, shapes: {file: " + (folder.path() / "shapes.csv").string() + ", points: [1, 2, 3]}");
    for (const char* stiffness : {"1.3 kN/m", "0.8 kN/m", "1.1 kN/m"}) text = test::changed(text, stiffness, "1 kN/m");
    const auto study = test::study_of(text);
    return summarise(study, run_study(study, "correlate", {}));
  };
  const auto right = correlated(1.0), wrong = correlated(-1.0);
  EXPECT_TRUE(right["verdict"]["state"].is_null());
  EXPECT_TRUE(right["correlation"]["comparisons"]["modes"]["mistakes"].empty());
  EXPECT_NEAR(right["correlation"]["comparisons"]["modes"]["modes"][2]["mac"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(wrong["verdict"]["state"], "suspicious");
  EXPECT_EQ(wrong["verdict"]["reasons"][0]["code"], "setup_mistake");
  const auto& mistake = wrong["correlation"]["comparisons"]["modes"]["mistakes"][0];
  EXPECT_EQ(mistake["kind"], "turned");
  EXPECT_EQ(mistake["sensors"][0], "2");
  const auto& expansion = right["correlation"]["comparisons"]["modes"]["expansion"];
  EXPECT_EQ(expansion["method"], "model");
  EXPECT_LT(expansion["modes"][1]["band"].get<double>(), 0.02);
  EXPECT_NEAR(expansion["points"]["2"]["shape"][0].get<double>(), std::sin(2.0 * M_PI / 7.0), 1e-3);
}

/// Receptances of one mass, with damping of 2 %, in a table; the second case has the column against its direction.
TEST(Compared, AResponseThatIsTurnedIsInVerdictAndSummary) {
  const ScratchFolder folder("responses");
  const auto correlated = [&](double sign) {
    std::ofstream file(folder.path() / "frf.csv");
    file << "f,1_re,1_im\n";
    for (double f = 1.0; f < 10.0; f += 0.05) {
      const double omega = 2.0 * M_PI * f;
      const std::complex<double> response =
          sign / std::complex<double>(1000.0 - omega * omega, 0.04 * std::sqrt(1000.0) * omega);
      file << f << "," << response.real() << "," << response.imag() << "\n";
    }
    file.close();
    const auto study = test::study_of(
        "kalfem: 1\nsubstructures:\n  s: {masses: {1: 1 kg}, springs: [{name: k, from: ground, to: 1, stiffness: 1 "
        "kN/m}], damping: {modal: 2 %}}\nupdate:\n  parameters: {s.k.stiffness: {}}\n  compare:\n    tap: {frf: s, "
        "inputs: [{force: 1, file: " +
        (folder.path() / "frf.csv").string() + "}], outputs: [1], quantity: displacement, smoothing: 0 Hz}\n");
    return summarise(study, run_study(study, "correlate", {}));
  };
  const auto right = correlated(1.0), wrong = correlated(-1.0);
  const auto& response = right["correlation"]["comparisons"]["tap"]["responses"][0];
  EXPECT_GT(response["frac"].get<double>(), 1.0 - 1e-6);
  EXPECT_NEAR(response["model_to_measured"].get<double>(), 1.0, 1e-3);
  EXPECT_NEAR(response["phase_deg"].get<double>(), 0.0, 0.1);
  EXPECT_TRUE(right["verdict"]["state"].is_null());
  EXPECT_EQ(wrong["verdict"]["state"], "suspicious");
  EXPECT_EQ(wrong["verdict"]["reasons"][0]["code"], "setup_mistake");
}

TEST(Compared, AFailedRunIsUnusableWhateverItDid) {
  StudyResults results;
  results.failure = "the matrix is singular";
  EXPECT_TRUE(has_verdict(results));
}

/// The table holds the modes of both models and says which are which.
TEST(UpdatedModes, StandBesideThoseOfTheInitialModel) {
  const auto study = test::study_of(updated_chain);
  const auto results = run_study(study, "update", {});
  const auto* updated = updated_modes_of(results, "frame");
  ASSERT_NE(updated, nullptr);
  EXPECT_NEAR(updated->frequencies[0], 2.2398607, 1e-5);  // the search ends within 1e-5 of the parameters
  EXPECT_NEAR(updated->frequencies[2], 9.0690107, 1e-5);
  const double initial = modes_found(results).substructures.front().frequencies[0];
  EXPECT_GT(std::abs(initial - 2.2398607), 0.01);
  const Table table = modes_table(study, results);
  EXPECT_EQ(table.columns,
            (std::vector<std::string>{"substructure", "mode", "updated, full [Hz]", "initial, full [Hz]"}));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0][2], "2.24");
  EXPECT_NE(table.rows[0][3], "2.24");
  EXPECT_NE(table.caption.find("at the updated values"), std::string::npos);
  const auto frame = summarise(study, results)["model"]["substructures"]["frame"];
  EXPECT_NEAR(frame["updated_frequencies_hz"][0].get<double>(), 2.2398607, 1e-5);
  EXPECT_NEAR(frame["frequencies_hz"][0].get<double>(), initial, 1e-12);
}

/// Without an updating nothing is labelled.
TEST(UpdatedModes, AreNotThereWithoutAnUpdating) {
  const auto study = test::study_of(updated_chain);
  const auto results = run_study(study, "modes", {});
  EXPECT_EQ(modes_table(study, results).columns, (std::vector<std::string>{"substructure", "mode", "full [Hz]"}));
  EXPECT_FALSE(summarise(study, results)["model"]["substructures"]["frame"].contains("updated_frequencies_hz"));
}

}  // namespace
}  // namespace kalfem
