// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>

#include "base/absent.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/calculix.hpp"

// How loads and supports of one step and of several act together, against CalculiX (ccx) on the same file.

namespace kalfem::test {
namespace {

using Eigen::Vector3d;

/// Two hexahedra along x, held at x = 0.
const std::string bar = R"(*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 2, 0, 0
4, 0, 1, 0
5, 1, 1.1, 0
6, 2, 1, 0
7, 0, 0, 1
8, 1, 0, 1
9, 2, 0, 1.1
10, 0, 1, 1
11, 1, 1, 1
12, 2, 1, 1
*NSET, NSET=ROOT
1, 4, 7, 10
*NSET, NSET=TIP
3, 6, 9, 12
*ELEMENT, TYPE=C3D8, ELSET=BAR
1, 1, 2, 5, 4, 7, 8, 11, 10
2, 2, 3, 6, 5, 8, 9, 12, 11
*ELSET, ELSET=END
2
*SURFACE, NAME=TOP
BAR, S2
*SOLID SECTION, ELSET=BAR, MATERIAL=M
*MATERIAL, NAME=M
*ELASTIC
1.e5, 0.3
*DENSITY
2.
*AMPLITUDE, NAME=RAMP
0., 0., 0.5, 0.2, 2., 0.8
*BOUNDARY
ROOT, 1, 3
)";

std::string step(const std::string& loads, const std::string& options = "") {
  return "*STEP" + options + "\n*STATIC\n" + loads + "*NODE PRINT, NSET=ALL, GLOBAL=YES\nU\n*END STEP\n";
}

struct Rule {
  const char* name;
  std::string steps;
};

void PrintTo(const Rule& rule, std::ostream* stream) { *stream << rule.name; }

std::vector<Rule> rules() {
  const std::string force = "*CLOAD\n6, 3, 2.\n3, 2, 1.\n", pressure = "*DLOAD\nEND, P2, 3.\n";
  return {
      {"ForcesOfAStepAddUp", step("*CLOAD\n6, 3, 2.\n6, 3, 1.\n*CLOAD\nTIP, 3, 0.5\n")},
      {"LaterForcesReplace", step(force) + step("*CLOAD\n6, 3, 1.\n")},
      {"LaterForcesReplaceAndAddUp", step(force) + step("*CLOAD\n6, 3, 1.\n6, 3, 0.5\n*CLOAD\n6, 3, 0.2\n")},
      {"ForcesGoOn", step(force) + step("*DLOAD\nEND, P2, 1.\n")},
      {"NewForces", step(force) + step("*CLOAD, OP=NEW\n12, 1, 1.\n")},
      {"NewForcesInTheSecondBlock", step(force) + step("*CLOAD\n6, 3, 1.\n*CLOAD, OP=NEW\n12, 1, 1.\n")},
      {"PressuresOfAStepAddUp", step("*DLOAD\nBAR, P2, 3.\n2, P2, 1.\n*DLOAD\nEND, P2, 1.\n")},
      {"LaterPressuresReplace", step(pressure) + step("*DLOAD\nBAR, P2, 5.\n")},
      {"PressuresGoOn", step(pressure) + step("*DLOAD\nEND, P1, 5.\n")},
      {"NewPressures", step(pressure + force) + step("*DLOAD, OP=NEW\nEND, P4, 5.\n")},
      {"SurfacesAndFacesAddUp", step("*DSLOAD\nTOP, P, 2.\n*DLOAD\nEND, P2, 1.\n")},
      {"LaterFacesReplaceThoseOfSurfaces", step("*DSLOAD\nTOP, P, 2.\n") + step("*DLOAD\nEND, P2, 1.\n")},
      {"NewSurfacesRemoveFaces", step(pressure) + step("*DSLOAD, OP=NEW\nTOP, P, 2.\n")},
      {"NewFacesRemoveSurfaces", step("*DSLOAD\nTOP, P, 2.\n") + step("*DLOAD, OP=NEW\nEND, P4, 1.\n")},
      {"Weights", step("*DLOAD\nBAR, GRAV, 9., 0., 0., -1.\nBAR, GRAV, 3., 0., 0., -1.\nBAR, GRAV, 2., 1., 0., 0.\n")},
      {"LaterWeightReplaces",
       step("*DLOAD\nBAR, GRAV, 9., 0., 0., -1.\n") + step("*DLOAD\nBAR, GRAV, 3., 0., 0., -1.\n")},
      {"LaterWeightOfAnotherDirection",
       step("*DLOAD\nBAR, GRAV, 9., 0., 0., -1.\n") + step("*DLOAD\nBAR, GRAV, 3., 0., 1., 0.\n")},
      {"LaterWeightOfAnotherSet",
       step("*DLOAD\nBAR, GRAV, 9., 0., 0., -1.\n") + step("*DLOAD\nEND, GRAV, 3., 0., 0., -1.\n")},
      {"WeightOfAPart", step("*DLOAD\nEND, GRAV, 9., 0., 0.6, -0.8\n")},
      {"Rotation", step("*DLOAD\nBAR, CENTRIF, 4., 0., 0.5, 0., 0., 0., 1.\n")},
      {"RotationOfAPart", step("*DLOAD\nEND, CENTRIF, 4., 0., 0.5, 0., 0., 0., 1.\n")},
      {"RotationsOfOneAxis",
       step("*DLOAD\nBAR, CENTRIF, 4., 0., 0.5, 0., 0., 0., 1.\nBAR, CENTRIF, 3., 0., 0.5, 0., 0., 0., 1.\n")},
      {"ForcesPerVolume", step("*DLOAD\nBAR, BX, 3.\nEND, BZ, 5.\n")},
      {"MotionsReplace", step("*BOUNDARY\nTIP, 2, 2, 0.01\n") + step("*BOUNDARY\nTIP, 2, 2, 0.03\n") +
                             step("*BOUNDARY\nTIP, 2, 2\n*CLOAD\n11, 1, 5.\n")},
      {"MotionsGoOn", step("*BOUNDARY\nTIP, 2, 2, 0.01\n") + step("*CLOAD\n11, 1, 5.\n")},
      {"SupportsThatBeginLater", step(force) + step("*BOUNDARY\n9, 1, 3\n") + step("")},
      {"NewSupports", step(force) + step("*BOUNDARY, OP=NEW\nTIP, 1, 3\n*CLOAD\n1, 3, 4.\n")},
      {"NewSupportsLiftMotions",
       step("*BOUNDARY\nTIP, 2, 2, 0.01\n") + step("*BOUNDARY, OP=NEW\nROOT, 1, 3\n*CLOAD\n6, 3, 4.\n")},
      {"NewSupportsInTheFirstStep", step("*BOUNDARY, OP=NEW\nTIP, 1, 3\n*CLOAD\n1, 3, 4.\n")},
      {"FixedWhereItWasMoved", step("*BOUNDARY\nTIP, 2, 2, 0.01\n") + step("*BOUNDARY, FIXED\nTIP, 2, 2\n")},
      {"ValueOfAnAmplitude", step("*CLOAD, AMPLITUDE=RAMP\n6, 3, 2.\n*DLOAD, AMPLITUDE=RAMP\nEND, P2, 3.\n")},
      {"PerturbationStandsAlone",
       step("*CLOAD\n6, 3, .002\n") + step("*CLOAD\n3, 2, .001\n", ", PERTURBATION") + step("*CLOAD\n9, 1, .001\n")},
  };
}

class StepRulesCalculix : public testing::TestWithParam<Rule> {};

TEST_P(StepRulesCalculix, GiveTheSameDisplacements) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const ScratchFolder folder("step-rules");
  std::ofstream(folder / "deck.inp") << bar << GetParam().steps;
  ASSERT_TRUE(run_calculix(folder, "deck"));
  const auto expected = displacements_in(folder / "deck.dat");
  const auto deck = read_abaqus(folder / "deck.inp", {.load_cases = true});
  ASSERT_FALSE(expected.empty());
  ASSERT_EQ(deck.load_cases.size(), expected.size());
  const NodeFinder nodes(deck.model.mesh);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto found = solve_statics(deck.model, deck.load_cases[i]).displacements;
    double largest = 0.0;
    for (const auto& [node, moved] : expected[i]) largest = std::max(largest, moved.norm());
    ASSERT_GT(largest, 0.0);
    for (const auto& [node, moved] : expected[i])
      EXPECT_LE((found.segment<3>(6 * nodes.find(node)) - moved).norm(), 5e-5 * largest)
          << "step " << i + 1 << ", node " << node << ": " << found.segment<3>(6 * nodes.find(node)).transpose()
          << " instead of " << moved.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, StepRulesCalculix, testing::ValuesIn(rules()),
                         [](const auto& each) { return std::string(each.param.name); });

/// A block under a reference node: coupling, its options, and what the step does.
std::string coupled(const std::string& coupling, const std::string& loads) {
  return "*NODE, NSET=ALL\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, "
         "1, 1\n"
         "20, .7, .4, 2.\n*NSET, NSET=BLOCK\n1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, "
         "6, "
         "7, 8\n*SURFACE, NAME=TOP\n1, S2\n*ORIENTATION, NAME=O\n0., 1., 0., -1., 0., 0.\n*MATERIAL, NAME=M\n*ELASTIC\n"
         "1000., 0.3\n*DENSITY\n1.\n*SOLID SECTION, ELSET=E, MATERIAL=M\n*BOUNDARY\n1, 1, 3\n2, 1, 3\n3, 1, 3\n4, 1, "
         "3\n" +
         coupling + "*STEP\n*STATIC\n" + loads + "*NODE PRINT, NSET=BLOCK\nU\n*END STEP\n";
}

void expect_block_moves_alike(const std::string& text) {
  const ScratchFolder folder("coupling-rules");
  std::ofstream(folder / "deck.inp") << text;
  ASSERT_TRUE(run_calculix(folder, "deck"));
  const auto expected = displacements_in(folder / "deck.dat");
  ASSERT_EQ(expected.size(), 1u);
  const auto deck = read_abaqus(folder / "deck.inp", {.load_cases = true});
  ASSERT_EQ(deck.load_cases.size(), 1u);
  const auto found = solve_statics(deck.model, deck.load_cases.front()).displacements;
  const NodeFinder nodes(deck.model.mesh);
  double largest = 0.0;
  for (const auto& [node, moved] : expected.front()) largest = std::max(largest, moved.norm());
  ASSERT_GT(largest, 0.0);
  for (const auto& [node, moved] : expected.front())
    EXPECT_LE((found.segment<3>(6 * nodes.find(node)) - moved).norm(), 5e-5 * largest) << "node " << node;
}

class CouplingsCalculix : public testing::Test {
protected:
  void SetUp() override {
    if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  }
};

const std::string tip = "*CLOAD\n20, 1, 4.\n20, 3, 8.\n";

TEST_F(CouplingsCalculix, DistributingCouplingSharesForcesWithoutMoments) {
  expect_block_moves_alike(
      coupled("*ELEMENT, TYPE=DCOUP3D, ELSET=D\n2, 20\n*DISTRIBUTING COUPLING, ELSET=D\n5, 1.\n6, "
              "1.\n7, 1.\n8, 3.\n",
              tip));
}

TEST_F(CouplingsCalculix, DistributingSharesMomentsToo) {
  expect_block_moves_alike(coupled("*COUPLING, REF NODE=20, SURFACE=TOP, CONSTRAINT NAME=C\n*DISTRIBUTING\n1, 6\n",
                                   tip + "*CLOAD\n20, 5, 1.\n"));
}

TEST_F(CouplingsCalculix, OrientationTurnsTheLoadsOfDistributing) {
  expect_block_moves_alike(
      coupled("*COUPLING, REF NODE=20, SURFACE=TOP, CONSTRAINT NAME=C, ORIENTATION=O\n*DISTRIBUTING\n1, 3\n", tip));
}

TEST_F(CouplingsCalculix, OrientationOfKinematicTurnsTheTiedDirections) {
  expect_block_moves_alike(
      coupled("*COUPLING, REF NODE=20, SURFACE=TOP, CONSTRAINT NAME=C, ORIENTATION=O\n*KINEMATIC\n2, 3\n",
              "*BOUNDARY\n20, 1, 1, 0.1\n20, 2, 2\n20, 3, 3, 0.05\n20, 4, 6\n"));
}

/// Cylindrical axes about a line beside the block.
std::string in_cylindrical_axes(std::string text) {
  const std::string rectangular = "*ORIENTATION, NAME=O\n0., 1., 0., -1., 0., 0.\n";
  return text.replace(text.find(rectangular), rectangular.size(),
                      "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n.1, .2, 0., .1, .2, 1.\n");
}

/// The reference node as the first node of the deck: equal coefficients of an equation are solved for the first one.
std::string with_reference_first(std::string text) {
  const std::string node = "20, .7, .4, 2.\n", begin = "*NODE, NSET=ALL\n";
  text.erase(text.find(node), node.size());
  return text.replace(text.find(begin), begin.size(), begin + node);
}

/// Couplings of some directions whose reference node, or one of the coupled ones, is held or moved.
TEST_F(CouplingsCalculix, HeldAndMovedInCylindricalAxes) {
  const auto kinematic = [](const std::string& lines) {
    return "*COUPLING, REF NODE=20, SURFACE=TOP, CONSTRAINT NAME=C, ORIENTATION=O\n*KINEMATIC\n" + lines;
  };
  const std::string held = "*BOUNDARY\n20, 1, 6\n", push = "*CLOAD\n7, 1, 3.\n";
  const std::string moved = "*BOUNDARY\n20, 1, 1, 0.1\n20, 2, 2\n20, 3, 3, 0.05\n20, 4, 6\n";
  const std::string texts[] = {
      coupled(held + kinematic("2, 3\n"), push),
      coupled(held + kinematic("1, 1\n"), push),
      coupled("*BOUNDARY\n20, 2, 6\n" + kinematic("1, 2\n"), "*CLOAD\n20, 1, 4.\n7, 2, 3.\n"),
      coupled("*BOUNDARY\n5, 3, 3\n20, 4, 6\n" + kinematic("1, 2\n"), "*CLOAD\n20, 1, 4.\n7, 2, 3.\n"),
      coupled(kinematic("1, 3\n"), moved),
      coupled(kinematic("2, 3\n"), moved),
      coupled(kinematic("1, 2\n"), moved),  // nothing follows along z
      coupled("*BOUNDARY\n20, 2, 6\n" + kinematic("1, 1\n"), "*BOUNDARY\n20, 1, 1, 0.02\n" + push),
      coupled("*COUPLING, REF NODE=20, SURFACE=TOP, CONSTRAINT NAME=C, ORIENTATION=O\n*DISTRIBUTING\n1, 3\n", tip),
  };
  for (const auto& text : texts)
    for (const bool first : {false, true}) {
      const std::string turned = in_cylindrical_axes(text);
      SCOPED_TRACE(first ? with_reference_first(turned) : turned);
      expect_block_moves_alike(first ? with_reference_first(turned) : turned);
    }
}

}  // namespace
}  // namespace kalfem::test
