// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "command.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/tables/frf_table.hpp"

namespace kalfem::test {
namespace {

using Json = nlohmann::json;

const std::string oscillator = R"(kalfem: 1
substructures:
  o: {masses: {m: 2 kg}, springs: [{from: ground, to: m, stiffness: 800 N/m, damping: 1.6 N s/m}]}
)";

/// A cantilever of ten beams along x, 1 m long, on a spring at its tip.
const std::string beam = R"(kalfem: 1
substructures:
  arm:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {bar: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}}}}
      nodes: {root: 1, mid: 6, tip: 11}
      fixed: {clamp: {nodes: root}}
    damping: {modal: 1 %, modal_up_to: 20 kHz}
    reduction: {up_to: 200 Hz}
connectors:
  stop: {from: arm.tip.z, to: ground, law: linear, parameters: {k: 1 kN/m, c: 1 N s/m}}
)";

class Frf : public testing::Test {
protected:
  Frf() {
    std::ofstream nodes(folder_ / "nodes.csv"), elements(folder_ / "elements.csv");
    nodes << "node,x_m,y_m,z_m\n1,0,0,0\n";
    elements << "element,node1,node2,region\n";
    for (int i = 1; i <= 10; ++i) {
      nodes << i + 1 << ',' << 0.1 * i << ",0,0\n";
      elements << i << ',' << i << ',' << i + 1 << ",bar\n";
    }
  }
  Outcome run(const std::string& text, const std::string& verb = "frf") {
    const std::string file = (folder_ / "case.yaml").string();
    std::ofstream(file) << text;
    return run_command(verb + " " + file + " --out " + (folder_ / "out").string(), folder_);
  }
  [[nodiscard]] Json summary() const { return read_summary(folder_ / "out")["frequency_response"]; }

  ScratchFolder folder_{"frf"};
};

// A peak at the natural frequency, sqrt(k / m) / 2 pi, with c / (2 sqrt(k m)) of damping; next to it |H| = 1 / (c
// omega).
TEST_F(Frf, WritesAResonanceInEveryFile) {
  const auto outcome = run(oscillator + R"(frequency_response:
  frequencies: {from: 1 Hz, to: 6 Hz, lines: 1001}
  inputs: [o.m, o.ground]
  outputs: [{displacement: o.m}]
  method: direct
)");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const double natural = 10.0 / std::numbers::pi;
  const Json responses = summary()["responses"];
  ASSERT_EQ(responses.size(), 2u);
  EXPECT_EQ(responses[0]["unit"], "m/N");
  EXPECT_FALSE(responses[0].contains("difference"));
  ASSERT_EQ(responses[0]["peaks"].size(), 1u);
  const Json peak = responses[0]["peaks"][0];
  // The fit is that of light damping: it errs by zeta^2.
  EXPECT_NEAR(peak["frequency_hz"].get<double>() / natural, 1.0, 5e-4);
  EXPECT_NEAR(peak["damping_ratio"].get<double>() / 0.02, 1.0, 1e-3);
  EXPECT_NEAR(peak["magnitude"].get<double>(), 1.0 / (1.6 * 20.0), 1e-4);

  const auto table = read_frf_table(folder_ / "out" / "frf_full_displacement_o.m.csv");
  ASSERT_EQ(table.lines.size(), 1001);
  ASSERT_EQ(table.outputs.size(), 1u);
  EXPECT_EQ(table.outputs[0].name, "o.m");
  EXPECT_EQ(table.outputs[0].unit, "m/N");
  const std::complex<double> s(0.0, 2.0 * std::numbers::pi * table.lines[200]);
  const auto expected = 1.0 / (800.0 + 1.6 * s + 2.0 * s * s);
  EXPECT_LT(std::abs(table.values(200, 0) - expected), 1e-12 * std::abs(expected));

  const Hdf5File file = Hdf5File::open((folder_ / "out" / "results.h5").string());
  EXPECT_EQ(file.shape("/frequency_response/o.ground/o.m/displacement/full")[0], 1001);
  const std::string page = read(folder_ / "out" / "report.html");
  EXPECT_NE(page.find("Frequency responses"), std::string::npos);
  EXPECT_NE(page.find("o.m per motion of o.ground"), std::string::npos);
  EXPECT_NE(outcome.output.find("2 frequency responses from 1 to 6 Hz"), std::string::npos) << outcome.output;
}

// The force acts in the middle, where the superelement has no boundary of its own.
TEST_F(Frf, ReducedModelIsThatOfTheFullOneToHalfItsCutOff) {
  for (const char* method : {"direct", "modal"}) {
    const auto outcome = run(beam + R"(frequency_response:
  frequencies: {from: 1 Hz, to: 100 Hz, lines: 500}
  inputs: [arm.mid.z, arm.tip.z]
  outputs: [{acceleration: arm.mid.z}, {acceleration: arm.tip.z}]
  model: both
  method: )" + std::string(method) +
                             "\n");
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const Json found = summary();
    EXPECT_EQ(found["full"]["dofs"], 60);
    EXPECT_LT(found["reduced"]["dofs"], 20);
    for (const auto& response : found["responses"]) {
      EXPECT_LT(response["difference"]["at_resonances"].get<double>(), 1e-3) << method << response;
      EXPECT_LT(response["difference"]["between"].get<double>(), 1e-2) << method << response;
    }
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "frf_reduced_acceleration_arm.tip.z.csv"));
  }
}

TEST_F(Frf, AnotherRunRemovesTheTablesOfTheOneBefore) {
  const std::string section = "frequency_response: {frequencies: [1, 2], inputs: [o.m], outputs: [{velocity: o.m}]}\n";
  ASSERT_EQ(run(oscillator + section).code, 0);
  const auto table = folder_ / "out" / "frf_full_velocity_o.m.csv";
  EXPECT_TRUE(std::filesystem::exists(table));
  ASSERT_EQ(run(oscillator + section, "modes").code, 0);
  EXPECT_FALSE(std::filesystem::exists(table));
  ASSERT_EQ(run(oscillator + section, "run").code, 0);
  EXPECT_TRUE(std::filesystem::exists(table));
}

TEST_F(Frf, WarnsOfLinesAboveTheCutOff) {
  const auto outcome = run(beam +
                           "frequency_response: {frequencies: {from: 1 Hz, to: 1 kHz}, inputs: [arm.tip.z], outputs: "
                           "[{velocity: arm.tip.z}], model: reduced}\n");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.errors.find("'arm' holds its modes only up to"), std::string::npos) << outcome.errors;
}

TEST_F(Frf, EachMistakeHasOneMessageWithItsLine) {
  struct Mistake {
    std::string change, message;
  };
  const std::string first = "frequencies: [1 Hz, 2 Hz]", input = "inputs: [o.m]", output = "outputs: [{velocity: o.m}]";
  const auto section = [](const std::string& a, const std::string& b, const std::string& c,
                          const std::string& more = "") { return "{" + a + ", " + b + ", " + c + more + "}"; };
  for (const auto& [text, message] :
       {Mistake{section("frequencies: {from: 5 Hz, to: 5 Hz}", input, output), "the band is empty"},
        {section("frequencies: {from: -1 Hz, to: 5 Hz}", input, output), "from"},
        {section("frequencies: {from: 0, to: 5, spacing: logarithmic}", input, output), "cannot begin at 0 Hz"},
        {section("frequencies: [2 Hz, 1 Hz]", input, output), "do not ascend"},
        {section("frequencies: []", input, output), "frequencies"},
        {section(first, "inputs: [o.n]", output), "no point or ground 'o.n' (did you mean 'o.m'"},
        {section(first, input, "outputs: [{velocity: m}]"), "no point 'm'"},
        {section(first, input, "outputs: [{velocity: o.ground}]"), "no point 'o.ground'"},
        {section(first, "inputs: [o.m, o.m]", output), "the input 'o.m' stands twice"},
        {section(first, input, "outputs: [{velocity: o.m}, {velocity: o.m}]"), "the output 'o.m' stands twice"},
        {section(first, input, output, ", substructure: p"), "no substructure 'p'"},
        {section(first, input, output, ", model: both"), "no finite elements to reduce"}}) {
    const auto outcome = run(oscillator + "frequency_response: " + text + "\n");
    EXPECT_EQ(outcome.code, 2) << text;
    EXPECT_NE(outcome.errors.find(message), std::string::npos) << text << "\n" << outcome.errors;
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << text << "\n" << outcome.errors;
    EXPECT_NE(outcome.errors.find("case.yaml:"), std::string::npos) << outcome.errors;
  }
  const auto without = run(oscillator);
  EXPECT_EQ(without.code, 2);
  EXPECT_NE(without.errors.find("the case has no `frequency_response`"), std::string::npos) << without.errors;
}

TEST_F(Frf, RefusesAnUndampedResonance) {
  std::string undamped = oscillator;
  undamped.replace(undamped.find(", damping: 1.6 N s/m"), 20, "");
  const auto outcome = run(undamped +
                           "frequency_response: {frequencies: [1, 3.1830988618379066], inputs: [o.m], outputs: "
                           "[{displacement: o.m}], method: direct}\n");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("singular at 3.1831 Hz"), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find("give the structure damping"), std::string::npos) << outcome.errors;
}

// To half the cut-off of 300 Hz; the frame alone and on its suspensions, from the road and by forces.
TEST_F(Frf, OfTheVehicleWithResidualVectorsAreThoseOfTheFullFrame) {
  for (const std::string part :
       {"",
        " --set frequency_response.substructure=frame --set "
        "'frequency_response.inputs=[frame.p1.z, frame.p6.z]' --set "
        "'frequency_response.outputs=[{acceleration: frame.p6.z}, {acceleration: frame.p1.z}]'"}) {
    const auto outcome =
        run_command("frf " + example("vehicle/frf.yaml") + part +
                        " --set substructures.frame.finite_elements.mesh=" + example("vehicle/small.msh") +
                        " --set frequency_response.method=direct --set frequency_response.frequencies.lines=60 --out " +
                        (folder_ / "out").string(),
                    folder_);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    for (const auto& response : summary()["responses"]) {
      EXPECT_LT(response["difference"]["at_resonances"].get<double>(), 1e-3) << response;
      EXPECT_LT(response["difference"]["between"].get<double>(), 1e-2) << response;
    }
  }
}

// The gauge of a slowly loaded cantilever reads the static strain, F (L - x) e / E I, and at every line that of the
// full model: the superelement carries the gauge.
TEST_F(Frf, GivesStrainAtGauges) {
  std::string text = beam;
  text.replace(text.find("connectors"), std::string::npos, "");
  text.insert(text.find("      fixed:"), "      gauges: {g: {element: 3, fibre: [0, 5 mm]}}\n");
  text.replace(text.find("{up_to: 200 Hz}"), 15, "{up_to: 200 Hz, boundary: [tip]}");
  text.insert(text.find("    damping:"), "    springs: [{from: ground, to: tip.z, stiffness: 1e-3 N/m}]\n");
  const auto outcome = run(text + R"(frequency_response:
  frequencies: {from: 0.05 Hz, to: 60 Hz, lines: 1200}
  inputs: [arm.tip.z, arm.ground]
  outputs: [{strain: arm.g}, {acceleration: arm.tip.z}]
  model: both
  method: direct
)");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json responses = summary()["responses"];
  ASSERT_EQ(responses.size(), 4u);
  EXPECT_EQ(responses[0]["unit"], "(m/m)/N");
  EXPECT_EQ(responses[2]["unit"], "(m/m)/m");
  EXPECT_LT(responses[0]["difference"]["at_resonances"].get<double>(), 0.02);
  const std::string table = read(folder_ / "out" / "frf_full_strain_arm.tip.z.csv");
  EXPECT_NE(table.find("arm.g_re [(m/m)/N]"), std::string::npos) << table.substr(0, 200);
  const std::string first = table.substr(table.find("\n") + 1);
  const double slow = std::stod(first.substr(first.find(',') + 1));
  const double inertia = 0.02 * std::pow(0.01, 3) / 12.0;
  const double expected = -5e-3 * (1.0 - 0.25) / (210e9 * inertia);
  EXPECT_NEAR(slow, expected, 1e-4 * std::abs(expected));
}

TEST_F(Frf, RefusesLinesWithoutAFiniteResponse) {
  const std::string undamped =
      "kalfem: 1\nsubstructures:\n  o: {masses: {m: 1, n: 1}, springs: [{from: m, to: n, stiffness: 200}]}\n";
  for (const std::string method : {"modal", "direct"}) {
    const auto asked = [&](const std::string& line) {
      return run(undamped + "frequency_response: {frequencies: [" + line +
                 "], inputs: [o.m], outputs: [{displacement: o.n}], method: " + method + "}\n");
    };
    const auto still = asked("0 Hz");
    EXPECT_EQ(still.code, 2) << method;
    EXPECT_NE(still.errors.find(
                  "case.yaml:4: the equations of motion are singular at 0 Hz: the structure can move as a rigid body"),
              std::string::npos)
        << still.errors;
    char line[40];
    std::snprintf(line, sizeof line, "%.17g Hz", 20.0 / (2.0 * std::numbers::pi));
    const auto resonant = asked(line);
    EXPECT_EQ(resonant.code, 2) << method;
    EXPECT_NE(resonant.errors.find("an undamped mode resonates there"), std::string::npos) << resonant.errors;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "summary.json"));
  }
}

}  // namespace
}  // namespace kalfem::test
