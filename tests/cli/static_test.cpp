// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "command.hpp"

namespace kalfem::test {
namespace {

using Json = nlohmann::json;

/// A cantilever of two beams, 1 m long.
const std::string beam = R"(kalfem: 1
substructures:
  arm:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {bar: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}}}}
      nodes: {root: 1, mid: 2, tip: 3}
      fixed: {clamp: {nodes: root}}
)";

class Static : public testing::Test {
protected:
  Static() {
    std::ofstream(folder_ / "nodes.csv") << "node,x_m,y_m,z_m\n1,0,0,0\n2,0.5,0,0\n3,1,0,0\n";
    std::ofstream(folder_ / "elements.csv") << "element,node1,node2,region\n1,1,2,bar\n2,2,3,bar\n";
  }
  Outcome run(const std::string& text, const std::string& verb = "static") {
    const std::string file = (folder_ / "case.yaml").string();
    std::ofstream(file) << text;
    return run_command(verb + " " + file + " --out " + (folder_ / "out").string(), folder_);
  }
  [[nodiscard]] Json statics() const { return read_summary(folder_ / "out")["statics"]; }

  ScratchFolder folder_{"static"};
};

// Heywood: 3.03 of the stress far from the hole, for a hole of a tenth of the width.
TEST_F(Static, PlateWithAHoleHasItsStressConcentration) {
  const auto outcome =
      run_command("static " + example("static/hole.yaml") + " --out " + (folder_ / "out").string(), folder_);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const Json tension = statics()["tension"];
  const double concentration = tension["displacements"]["top_of_hole"]["stress"]["tensor"][0].get<double>() / 1e8;
  EXPECT_NEAR(concentration, 3.03, 0.02 * 3.03);
  EXPECT_NEAR(tension["displacements"]["side_of_hole"]["stress"]["tensor"][1].get<double>() / 1e8, -1.11, 0.06);
  EXPECT_EQ(tension["stress_max"]["region"], "plate");
  EXPECT_NEAR(tension["stress_max"]["von_mises"].get<double>() / 1e8, concentration, 0.02);
  EXPECT_EQ(tension["stress_max"]["node"], tension["displacements"]["top_of_hole"]["node"]);
  EXPECT_NEAR(tension["reactions"]["symmetry_left"]["force"][0].get<double>(), -5e4, 1e-3);
  EXPECT_LT(tension["imbalance"].get<double>(), 1e-9);
  EXPECT_NE(outcome.output.find("the largest stress is"), std::string::npos);
  for (const char* file : {"summary.json", "report.html", "case.resolved.yaml", "quarter_static.vtu"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / file)) << file;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "quarter_modes.vtu"));
  const std::string page = read(folder_ / "out" / "report.html"), fields = read(folder_ / "out" / "quarter_static.vtu");
  EXPECT_NE(page.find("Statics of "), std::string::npos);
  EXPECT_NE(page.find("Load case tension"), std::string::npos);
  for (const char* name : {"tension: displacement", "tension: von Mises stress", "tension: stress", "tension: strain"})
    EXPECT_NE(fields.find("Name=\"" + std::string(name) + "\""), std::string::npos) << name;
}

TEST_F(Static, ReportsBeamsWithTheirExtremeFibres) {
  const auto outcome = run(beam + R"(static:
  substructure: arm
  cases: {lift: {forces: [{at: tip, force: [0, 0, 100 N]}]}, sag: {gravity: [0, 0, -9.81]}}
  points: tip
)");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json lift = statics()["lift"], sag = statics()["sag"];
  EXPECT_EQ(lift["displacements"].size(), 1u);
  EXPECT_NEAR(lift["stress_max"]["axial"].get<double>(), 100.0 / (0.02 * 1e-4 / 6.0), 1.0);
  EXPECT_EQ(lift["stress_max"]["element"], 1);
  EXPECT_NEAR(sag["reactions"]["clamp"]["force"][2].get<double>(), 2e-4 * 7850.0 * 9.81, 1e-6);
  EXPECT_NE(read(folder_ / "out" / "arm_static.vtu").find("lift: axial stress of beams"), std::string::npos);
}

TEST_F(Static, PreloadRaisesTheFrequencies) {
  const std::string loads = "static: {substructure: arm, cases: {pull: {forces: [{at: tip, force: [5 kN, 0, 0]}]}}}\n";
  ASSERT_EQ(run(beam + loads, "modes").code, 0);
  const auto frequency = [&] {
    return read_summary(folder_ / "out")["model"]["substructures"]["arm"]["frequencies_hz"][0].get<double>();
  };
  const double free = frequency();
  const auto outcome = run(beam + "    preload: pull\n" + loads, "modes");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_GT(frequency(), 1.5 * free);
}

TEST_F(Static, EachMistakeHasOneMessageWithItsLine) {
  struct Mistake {
    std::string statics, message;
  };
  for (const auto& [text, message] :
       {Mistake{"{substructure: leg, cases: {a: {gravity: [0, 0, 1]}}}", "no finite-element substructure 'leg'"},
        {"{substructure: arm, cases: {}}", "there is no load case"},
        {"{substructure: arm, cases: {a: {}}}", "the load case has no load"},
        {"{substructure: arm, cases: {a: {forces: [{at: top, force: [1, 0, 0]}]}}}", "no node or group 'top'"},
        {"{substructure: arm, cases: {a: {forces: [{at: tip}]}}}", "the load is zero"},
        {"{substructure: arm, cases: {a: {pressures: [{on: bar, pressure: 1}]}}}", "the group 'bar' holds no faces"},
        {"{substructure: arm, cases: {a: {pressures: [{on: bar, pressure: 0}]}}}", "the pressure is zero"},
        {"{substructure: arm, cases: {a: {forces: [{at: root, force: [0, 0, 1]}]}}}", "'arm' acts on supports alone"},
        {"{substructure: arm, cases: {a: {rotation: {axis: [0, 0, 0], speed: 3}}}}", "has no axis or no speed"},
        {"{substructure: arm, cases: {a: {displacements: {root.z: 1 mm}}}}", "which the support 'clamp' holds"},
        {"{substructure: arm, cases: {a: {displacements: {tip: 1 mm}}}}", "'tip' has no direction"},
        {"{substructure: arm, cases: {a: {gravity: [0, 0, 1]}}, points: top}", "no node 'top'"}}) {
    const auto outcome = run(beam + "static: " + text + "\n");
    EXPECT_EQ(outcome.code, 2) << text;
    EXPECT_NE(outcome.errors.find(message), std::string::npos) << text << "\n" << outcome.errors;
    EXPECT_NE(outcome.errors.find("case.yaml:"), std::string::npos) << outcome.errors;
  }
  const auto without = run(beam);
  EXPECT_EQ(without.code, 2);
  EXPECT_NE(without.errors.find("the case has no `static`"), std::string::npos) << without.errors;
  std::string hinged = beam;
  hinged.replace(hinged.find("{nodes: root}"), 13, "{nodes: root, directions: [x, y, z]}");
  const auto free = run(hinged + "static: {substructure: arm, cases: {a: {gravity: [0, 0, 1]}}}\n");
  EXPECT_EQ(free.code, 2);
  EXPECT_NE(free.errors.find("'arm' is free to move: it can turn about x through"), std::string::npos) << free.errors;
}

}  // namespace
}  // namespace kalfem::test
