// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>

#include "base/absent.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/calculix.hpp"
#include "model/preloaded.hpp"

// *STEP, PERTURBATION behind static steps: its stiffness has the stresses of the last one. Against CalculiX (ccx) on
// the same file, static perturbations and the modes of perturbations.

namespace kalfem::test {
namespace {

/// A slender bar along x, 1 m x 0.05 m x 0.02 m, of 10 x 1 x 1 hexahedra with 20 nodes, held at x = 0.
std::string slender_bar() {
  constexpr int elements = 10;
  const auto number = [](int i, int j, int k) { return std::to_string(1 + 100 * i + 10 * j + k); };
  std::string nodes = "*NODE, NSET=ALL\n", cells = "*ELEMENT, TYPE=C3D20, ELSET=BAR\n", root = "*NSET, NSET=ROOT\n",
              tip = "*NSET, NSET=TIP\n";
  for (int i = 0; i <= 2 * elements; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        if (i % 2 + j % 2 + k % 2 > 1) continue;
        nodes += number(i, j, k) + ", " + std::to_string(0.5 * i / elements) + ", " + std::to_string(0.025 * j) + ", " +
                 std::to_string(0.01 * k) + "\n";
        if (i == 0) root += number(i, j, k) + "\n";
        if (i == 2 * elements) tip += number(i, j, k) + "\n";
      }
  constexpr std::array<std::array<int, 3>, 20> places = {
      {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
       {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};
  for (int e = 0; e < elements; ++e) {
    cells += std::to_string(e + 1);
    for (std::size_t n = 0; n < places.size(); ++n)
      cells += (n == 10 ? ",\n" : ", ") + number(2 * e + places[n][0], places[n][1], places[n][2]);
    cells += "\n";
  }
  return nodes + cells + root + tip +
         "*MATERIAL, NAME=M\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7800.\n*SOLID SECTION, ELSET=BAR, MATERIAL=M\n"
         "*BOUNDARY\nROOT, 1, 3\n";
}

const std::string print = "*NODE PRINT, NSET=ALL, GLOBAL=YES\nU\n";
std::string step(const std::string& loads, const std::string& options = "", const std::string& output = print) {
  return "*STEP" + options + "\n*STATIC\n" + loads + output + "*END STEP\n";
}
std::string modes(const std::string& options = "") { return "*STEP" + options + "\n*FREQUENCY\n3\n*END STEP\n"; }

constexpr const char* perturbation = ", PERTURBATION";
const std::string pull = "*CLOAD\nTIP, 1, 3000.\n", push = "*CLOAD\nTIP, 1, -1000.\n", bend = "*CLOAD\nTIP, 3, 10.\n",
                  sway = "*CLOAD\nTIP, 2, 10.\n", press = "*DLOAD\n10, P4, -2e7\n",
                  spin = "*DLOAD\nBAR, CENTRIF, 40000., -0.1, 0.025, 0., 0., 0., 1.\n";

struct Rule {
  const char* name;
  std::string steps;
};
void PrintTo(const Rule& rule, std::ostream* stream) { *stream << rule.name; }

class Perturbations : public testing::TestWithParam<Rule> {
protected:
  void SetUp() override {
    if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
    std::ofstream(folder / "deck.inp") << slender_bar() << GetParam().steps;
    ASSERT_TRUE(run_calculix(folder, "deck"));
  }

  ScratchFolder folder{"perturbations"};
};

class StaticPerturbationsCalculix : public Perturbations {};

/// The stiffnesses due to stress agree but for the integration of the elements.
TEST_P(StaticPerturbationsCalculix, GiveTheSameDisplacements) {
  auto expected = displacements_in(folder / "deck.dat");
  const auto deck = read_abaqus(folder / "deck.inp", {.load_cases = true});
  ASSERT_FALSE(expected.empty());
  if (GetParam().steps.find("*FREQUENCY") != std::string::npos)  // the modes' displacements stand between the others
    expected.erase(expected.begin() + 1, expected.end() - 1);
  ASSERT_EQ(deck.load_cases.size(), expected.size());
  const StaticAnalysis analysis(deck.model, deck.load_cases);
  const NodeFinder nodes(deck.model.mesh);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto solution = analysis.solve(i);
    double largest = 0.0;
    for (const auto& [node, moved] : expected[i]) largest = std::max(largest, moved.norm());
    ASSERT_GT(largest, 0.0);
    for (const auto& [node, moved] : expected[i])
      EXPECT_LE((solution.displacements.segment<3>(6 * nodes.find(node)) - moved).norm(), 2e-3 * largest)
          << "step " << i + 1 << ", node " << node << ": "
          << solution.displacements.segment<3>(6 * nodes.find(node)).transpose() << " instead of " << moved.transpose();
    EXPECT_LT(solution.imbalance, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Rules, StaticPerturbationsCalculix,
    testing::Values(Rule{"PulledThenBent", step(pull) + step(bend, perturbation)},
                    Rule{"PushedThenBent", step(push) + step(bend, perturbation)},
                    Rule{"OfAPerturbation", step(pull) + step(push, perturbation) + step(bend, perturbation)},
                    Rule{"TheFirstStepIsOne", step(pull, perturbation) + step(bend, perturbation)},
                    Rule{"NextStepIsNone", step(pull) + step(bend, perturbation) + step("*BOUNDARY\nTIP, 2, 2\n")},
                    Rule{"ModesBetween", step(pull) + modes(perturbation) + step(bend, perturbation)},
                    Rule{"TwoLoadsBefore", step(pull) + step(bend) + step(sway, perturbation)},
                    Rule{"PressedThenBent", step(press) + step(bend, perturbation) + step(sway)},
                    Rule{"HeldBack",
                         step("*BOUNDARY\nTIP, 1, 1, 1e-4\n") + step("*BOUNDARY\nTIP, 1, 1\n" + bend, perturbation)},
                    Rule{"RotatingThenLoaded", step(spin) + step(bend, perturbation)},
                    Rule{"RotatingInBoth", step(spin) + step(spin + bend, perturbation)}),
    [](const auto& each) { return std::string(each.param.name); });

std::string quiet(const std::string& loads, const std::string& options = "") { return step(loads, options, ""); }

class PerturbationModesCalculix : public Perturbations {};

TEST_P(PerturbationModesCalculix, HaveTheStressOfTheLastStaticStep) {
  const auto expected = frequencies_in(folder / "deck.dat");
  const auto deck = read_abaqus(folder / "deck.inp");
  ASSERT_EQ(expected.size(), 3u);
  ASSERT_TRUE(deck.preload);
  const Eigen::VectorXd found = preloaded_frequencies(deck.model, *deck.preload, 3);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[static_cast<std::size_t>(i)], 2e-3 * found[i]);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, PerturbationModesCalculix,
    testing::Values(Rule{"Pulled", quiet(pull) + modes(perturbation)},
                    Rule{"BentBehindThePull", quiet(pull) + quiet(bend, perturbation) + modes(perturbation)},
                    Rule{"PushedBehindThePull", quiet(pull) + quiet(push, perturbation) + modes(perturbation)},
                    Rule{"PushedAlone", quiet(push, perturbation) + modes(perturbation)},
                    Rule{"Rotating", quiet(spin) + modes(perturbation)}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace kalfem::test
